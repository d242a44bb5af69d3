#!/usr/bin/env bash
# Each C++ block of the documentation is quoted from a file that is compiled and tested:
#   <!-- examples/well/well.cpp -->
#   ```cpp
#   ...
# So is any other block, a message or a script for instance, that has such a line before it.
# A block may leave out whole parts with a line "// ..."; each part must be lines of the file, in the
# same order, apart from indentation.
#   quotes.sh ROOT [FILE.md ...]
set -euo pipefail
root=$1
shift
(($#)) || set -- "$root"/*.md "$root"/docs/*.md "$root"/docs/*/*.md
failed=0 blocks=0

complain() { echo "$1:$2: $3"; failed=1; }

for page in "$@"; do
  number=0 source='' inside=no start=0 block=()
  while IFS= read -r line || [[ -n $line ]]; do
    number=$((number + 1))
    if [[ $inside == no ]]; then
      if [[ $line == '```cpp'* || ($line == '```'* && -n $source) ]]; then
        inside=yes start=$number block=()
        [[ -n $source ]] || complain "$page" "$number" "a C++ block without the file it is from"
      elif [[ $line == '```'* ]]; then
        inside=skipped
      elif [[ $line =~ ^'<!-- '([^ ]+)' -->'$ ]]; then
        source=${BASH_REMATCH[1]}
        [[ -f $root/$source ]] || { complain "$page" "$number" "there is no $source"; source=''; }
      elif [[ -n $line ]]; then
        source=''
      fi
    elif [[ $line == '```' && $inside == skipped ]]; then
      inside=no
    elif [[ $line == '```' ]]; then
      inside=no blocks=$((blocks + 1))
      if [[ -n $source ]]; then
        printf '%s\n' "${block[@]}" | awk -v file="$root/$source" '
          function bare(s) { gsub(/^[ \t]+|[ \t]+$/, "", s); return s }
          BEGIN { while ((getline s < file) > 0) if (bare(s) != "") text[++n] = bare(s) }
          { s = bare($0) }
          s == "" { next }
          s == "// ..." { find(); next }
          { part[++m] = s }
          END { if (!failed) find() }
          function find(i, k, far) {  # the part, behind those before it
            for (i = at + 1; m > 0 && i + m - 1 <= n; ++i) {
              for (k = 1; k <= m && text[i + k - 1] == part[k]; ++k) if (k > far) far = k
              if (k > m) { at = i + m - 1; m = 0 }
            }
            if (m == 0) return
            print "not in " file " there: " part[far < m ? far + 1 : m]
            failed = 1
            exit 1
          }' || complain "$page" "$start" "the block differs from $source"
      fi
      source=''
    else
      block+=("$line")
    fi
  done <"$page"
done
echo "$blocks blocks"
exit $failed
