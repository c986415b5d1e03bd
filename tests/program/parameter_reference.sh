#!/bin/sh
# doc/parameters.prm and doc/study.prm, the references of all parameters, are
# what emmy prints.
#
# Usage: parameter_reference.sh EMMY SOURCE_ROOT
set -eu

[ $# -eq 2 ] || { echo "usage: parameter_reference.sh EMMY SOURCE_ROOT" >&2; exit 2; }
emmy=$1
root=$2
printed=$(mktemp)
trap 'rm -f "$printed"' EXIT

# same FILE ARGUMENTS...: emmy prints this file
same()
{
  file=$1
  shift
  "$emmy" "$@" >"$printed"
  if ! diff -u "$root/$file" "$printed"; then
    echo "FAILED: $file differs from what emmy prints (lines with +)."
    echo "Remedy: in the source folder, run build/emmy $* > $file"
    exit 1
  fi
}
same doc/parameters.prm --print-parameters
same doc/study.prm study --print-parameters
