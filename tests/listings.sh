#!/usr/bin/env bash
# The tutorial has a row for each of the 40 listings of the pe tutorial, and each test that it names
# exists: [file](../path) "name of a test case", or [example](../examples/NAME/test.cmake)
# "example_NAME_SUFFIX". The targets of links exist (except those to pictures, which ./dev gallery
# draws).
#   listings.sh ROOT [TUTORIAL.md]
set -euo pipefail
root=$1
page=${2:-$root/docs/tutorial.md}
failed=0
complain() { echo "$page: $*"; failed=1; }

numbers=$(sed -n 's/^| \([0-9][0-9]*\) |.*/\1/p' "$page" | paste -sd ' ')
[[ $numbers == "$(seq -s ' ' 40)" ]] || complain "the listings are not 1 to 40, but: $numbers"
while read -r row; do
  [[ $row == *'](../'*' "'* ]] || complain "no test: $row"
done < <(grep -E '^\| [0-9]+ \|' "$page")

# The names of the test cases of a file, one a line, for any line breaks of the formatter.
cases() {
  tr '\n' ' ' <"$1" | sed 's/" *"//g; s/TEST_CASE( *"/\n"/g' | sed -n 's/^\("[^"]*"\)).*/\1/p'
}
tests=0
while IFS='|' read -r path name; do
  tests=$((tests + 1))
  file=$root/$path
  [[ -f $file ]] || { complain "there is no $path"; continue; }
  if [[ $path =~ ^examples/(.*)/test.cmake$ ]]; then
    suffix=${name#"example_${BASH_REMATCH[1]}_"}
    grep -q "add_example_test($suffix " "$file" || complain "$path has no test $name"
  else
    cases "$file" | grep -qxF "\"$name\"" || complain "$path has no test \"$name\""
  fi
done < <(grep -oE '\]\(\.\./[^)]*\) "[^"]*"' "$page" | sed -E 's/^\]\(\.\.\/([^)]*)\) "([^"]*)"$/\1|\2/')

while read -r link; do
  [[ -e $root/docs/$link ]] || complain "there is no $link"
done < <(sed '/^```/,/^```/d' "$page" | grep -oE '\]\([^)#]+\)' | sed -E 's/^\]\((.*)\)$/\1/' | grep -v '^images/' | sort -u || true)
while read -r anchor; do
  sed -n 's/^##* //p' "$page" | tr '[:upper:] ' '[:lower:]-' | tr -d '.,`' | grep -qx -- "$anchor" ||
    complain "there is no heading #$anchor"
done < <(grep -oE '\]\(#[^)]+\)' "$page" | sed -E 's/^\]\(#(.*)\)$/\1/' | sort -u)

echo "$tests tests"
exit $failed
