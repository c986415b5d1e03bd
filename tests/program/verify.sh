#!/bin/sh
# emmy verify, far from the source tree: all claims hold, the exit code says so,
# nothing is written; words it does not know are refused.
emmy=$1
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
mkdir "$work/empty"
cd "$work/empty" || exit 1
failed=0
check() # WHAT COMMAND...
{
  what=$1
  shift
  "$@" || { echo "FAILED: $what"; failed=1; }
}
"$emmy" verify >../out 2>../err
status=$?
cat ../out
check 'the exit code is 0' [ $status -eq 0 ]
check 'it ends with the verdict' [ "$(tail -n 1 ../out | grep -c '^all [0-9]* claims hold$')" -eq 1 ]
check 'the six scenes of the paper are there' [ "$(grep -c '^paper/7\.[1-4]' ../out)" -eq 6 ]
check 'there are many claims' [ "$(grep -c '^  holds ' ../out)" -ge 40 ]
check 'nothing fails' [ "$(grep -c FAIL ../out)" -eq 0 ]
check 'nothing is left behind' [ -z "$(ls -A)" ]
check 'nothing on the error output' [ ! -s ../err ]
"$emmy" verify soon >../out 2>&1
check 'another word is refused' [ $? -eq 1 ]
check 'with advice' grep -q 'emmy verify full' ../out
exit $failed
