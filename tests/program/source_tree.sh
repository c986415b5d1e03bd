#!/bin/sh
# Tests leave no file in the source tree: its names are listed before the first
# test and compared after the last. What Git ignores may come and go: build
# folders, results, files of editors. Nor lies there at the top what belongs in
# no release, as the results of a run begun there. Needs no Git.
#
# Usage: source_tree.sh list|compare SOURCE_ROOT BUILD_FOLDER
set -u

[ $# -eq 3 ] || { echo "usage: source_tree.sh list|compare SOURCE_ROOT BUILD_FOLDER" >&2; exit 2; }
source=$2
build=$3
before=$build/tests/source_tree.txt

# names: of all files and folders, those of results and build folders left out
names()
{
  (cd "$source" && find . \( -path './build*' -o -path './results/*' -o -path ./.git -o -path ./.cache \
    -o -path ./.idea -o -path ./.vscode \) -prune -o ! -path "./${build#"$source"/}/*" \
    ! -name '*~' ! -name '*.sw?' ! -name '#*#' ! -name '.#*' ! -name .DS_Store ! -name '*.orig' ! -name '*.rej' \
    ! -name compile_commands.json -print) | LC_ALL=C sort
}

case $1 in
  list)
    names >"$before"
    [ -s "$before" ] || { echo "FAILED: no files in $source" >&2; exit 1; }
    strange=$(sed 's|^\./\([^/]*\).*|\1|' "$before" | LC_ALL=C sort -u |
      grep -vxE '\..*|CMakeLists\.txt|source|include|prm|tests|doc|README\.md|LICENSE|CONTRIBUTING\.md|CITATION\.cff|run')
    [ -z "$strange" ] && exit 0
    echo "FAILED: these do not belong at the top of the source tree:"
    echo "$strange" | sed 's/^/  /'
    echo "Remedy: remove them, or name them in tests/program/source_tree.sh."
    exit 1
    ;;
  compare)
    new=$(names | LC_ALL=C comm -13 "$before" -)
    gone=$(names | LC_ALL=C comm -23 "$before" -)
    [ -z "$new$gone" ] && exit 0
    echo "FAILED: while tests ran, files came to the source tree or left it:"
    [ -z "$new" ] || echo "$new" | sed 's/^/  new:  /'
    [ -z "$gone" ] || echo "$gone" | sed 's/^/  gone: /'
    echo "Remedy: let the test write to a temporary folder; run the tests again if you moved the files."
    exit 1
    ;;
  *)
    exit 2
    ;;
esac
