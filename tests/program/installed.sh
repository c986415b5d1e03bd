#!/bin/sh
# What is installed: the program runs from there, with its page of the manual,
# its completion and what a package has to say of itself.
cmake=$1
build=$2
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
failed=0
check() # WHAT COMMAND...
{
  what=$1
  shift
  "$@" || { echo "FAILED: $what"; failed=1; }
}
"$cmake" --install "$build" --prefix "$work/usr" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
cd "$work/usr" || exit 1
check 'the program says its version' sh -c './bin/emmy --version | grep -qx "emmy [0-9.]*"'
check 'bash completes it' grep -q 'complete -o filenames -F _emmy emmy' share/bash-completion/completions/emmy
check 'it says how to cite it' grep -q '10.1016/j.jcp.2023.112075' share/doc/emmy/CITATION.cff
(cd share/doc/emmy && cp prm/examples/block.prm "$work/mine.prm") || failed=1
(cd "$work" && usr/bin/emmy mine.prm --set "Time/Maximum steps=2" --set Output/Pictures=false) >"$work/log" 2>&1 ||
  { cat "$work/log"; failed=1; }
check 'the guide'"'"'s scene is there and runs' [ -s "$work/results/block/report.html" ]
for link in $(grep -o '](doc/[^)#]*' share/doc/emmy/README.md | cut -c3-); do
  [ -e "share/doc/emmy/$link" ] || { echo "FAILED: README.md is installed without $link"; failed=1; }
done
if command -v help2man >/dev/null; then
  check 'its page of the manual has the options' grep -q 'print\\-parameters' share/man/man1/emmy.1
else
  echo 'no help2man: no page of the manual'
fi
exit $failed
