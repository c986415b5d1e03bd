#!/bin/sh
# Run the studies of prm/studies and put their tables and pictures into
# doc/accuracy-and-cost.md, each between <!-- study NAME --> and <!-- end -->.
# What has run is not run again, even if emmy was rebuilt: remove results/studies
# for fresh results and seconds. The machine should do nothing else meanwhile. Takes about an hour.
#
# Usage, in the root of the project: accuracy_and_cost.sh EMMY [NAME...]
set -eu

[ $# -ge 1 ] || { echo "usage: accuracy_and_cost.sh EMMY [NAME...]" >&2; exit 2; }
emmy=$1
shift
page=doc/accuracy-and-cost.md
[ -f "$page" ] || { echo "start it in the root of the project" >&2; exit 2; }
export OMP_NUM_THREADS=1 DEAL_II_NUM_THREADS=1 OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
names=${*:-$(sed -n 's/^<!-- study \([^ ]*\) -->$/\1/p' "$page")}

for name in $names; do
  study=prm/studies/$name.prm
  launch=
  case $name in ranks*) launch='mpirun -np 2' ;; esac
  $launch "$emmy" study "$study"
  folder=$(sed -n 's/^ *set Directory *= *//p' "$study")
  for picture in error-seconds error-size; do
    [ ! -f "$folder/$picture.png" ] || cp "$folder/$picture.png" "doc/pictures/$name-$picture.png"
  done
  # without its title and purpose, which the page has, and the list of members;
  # headings one level down
  sed -e '1,/^    emmy study/{/^    emmy study/!d;}' -e '/^## All members/,$d' \
    -e "s|^    emmy study|    ${launch:+$launch }emmy study|" -e 's/^## /### /' \
    -e "s|(error-\([a-z]*\)\.png)|(pictures/$name-error-\1.png)|" "$folder/study.md" >"$folder/part.md"
  awk -v name="$name" -v part="$folder/part.md" '
    $0 == "<!-- study " name " -->" { print; while ((getline line < part) > 0) print line; skip = 1 }
    $0 == "<!-- end -->" { skip = 0 }
    !skip && $0 != "<!-- study " name " -->"' "$page" >"$page.new"
  mv "$page.new" "$page"
done
