#!/usr/bin/env bash
# Passes if the compiler refuses a file with the sentence it expects among the first lines of its
# output, and compiles the file once its mistake is corrected.
#   check.sh COMPILER FLAGS_FILE SOURCE
# The source holds
#   // expects: <fragment>                         among its first lines; each must appear; comment
#                                                  lines below it continue the fragment
#   // within: <number> lines                    instead of 24, where the sentence must be seen at once
#   #ifdef TALUS_CONTROL ... #else ... #endif      the correct variant and the mistake
set -euo pipefail
compile=("$1" "@$2" -fsyntax-only -fmessage-length=0 -fdiagnostics-color=never -w)
source=$3
most_lines=$(head -n 8 "$source" | sed -nE 's|^// within: ([0-9]+) lines$|\1|p')
most_lines=${most_lines:-24}

mapfile -t fragments < <(head -n 8 "$source" | awk '
  /^\/\/ expects: */ { if (open) print text; text = $0; sub(/^\/\/ expects: */, "", text); open = 1; next }
  open && /^\/\/ / && $0 != "// long" && $0 !~ /^\/\/ within: / { text = text " " substr($0, 4); next }
  open { print text; open = 0 }')
if ((${#fragments[@]} == 0)) || ! grep -q TALUS_CONTROL "$source"; then
  echo "$source needs a first line '// expects: <fragment>' and a variant that compiles under" \
    "'#ifdef TALUS_CONTROL'"
  exit 1
fi
if out=$("${compile[@]}" "$source" 2>&1); then
  echo "$source compiles, but must be refused"
  exit 1
fi
first=$(head -n "$most_lines" <<<"$out")
for fragment in "${fragments[@]}"; do
  if [[ $first != *"$fragment"* ]]; then
    echo "$source is refused, but the first $most_lines lines of the message lack '$fragment':"
    head -n 200 <<<"$out"
    exit 1
  fi
done
if ! out=$("${compile[@]}" -DTALUS_CONTROL "$source" 2>&1); then
  echo "$source does not compile with TALUS_CONTROL either, so its refusal proves nothing:"
  head -n 200 <<<"$out"
  exit 1
fi
