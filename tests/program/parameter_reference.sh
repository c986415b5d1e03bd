#!/bin/sh
# doc/parameters.prm, the reference of all parameters, is what emmy prints.
#
# Usage: parameter_reference.sh EMMY SOURCE_ROOT
set -eu

[ $# -eq 2 ] || { echo "usage: parameter_reference.sh EMMY SOURCE_ROOT" >&2; exit 2; }
reference=$2/doc/parameters.prm
printed=$(mktemp)
trap 'rm -f "$printed"' EXIT

"$1" --print-parameters >"$printed"
if ! diff -u "$reference" "$printed"; then
  echo "FAILED: doc/parameters.prm differs from what emmy prints (lines with +)."
  echo "Remedy: in the source folder, run build/emmy --print-parameters > doc/parameters.prm"
  exit 1
fi
