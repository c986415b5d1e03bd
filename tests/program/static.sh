#!/bin/sh
# A run of static steps and one in time that starts from it: the body stays at
# rest, with the geometry of the middle and of the start. The scenes are those of
# prm/ground, on a coarser grid.
#
# Usage: static.sh EMMY SOURCE_ROOT

[ $# -eq 2 ] || { echo "usage: static.sh EMMY SOURCE_ROOT" >&2; exit 2; }
# shellcheck source=tests/program/checks.sh
. "$2/tests/program/checks.sh"
emmy=$(absolute "$1")
root=$(absolute "$2")
cd "$work" || exit 2

coarse='Grid/Cells=1, 24'
tall='Grid/Upper corner=0.5, 12'
wide='Bodies/b/box/Upper corner=0.5, 10'

emmy_run "$root/prm/ground/column.prm" --set "$coarse" --set "$tall" --set "$wide" \
  --set 'Output/Directory=column'
check 'static steps end' [ "$status" -eq 0 ]
check 'the log says how well it is settled' matches column/run.log 'loads were held'
# NAME FILE: the last value of a column
last()
{
  awk -F , -v name="$1" '
    NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) c = i; next }
    { value = $c }
    END { print value }' "$2"
}
largest()
{
  awk -F , -v name="$1" '
    NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) c = i; next }
    $c > value { value = $c }
    END { print value + 0 }' "$2"
}
is()
{
  awk "BEGIN { exit !($1) }"
}
stored=$(last strain_energy column/ledger.csv)
for geometry in middle start; do
  emmy_run "$root/prm/ground/column.prm" --set "$coarse" --set "$tall" \
    --set "$wide" --set 'Start/From=column' --set "Output/Directory=$geometry" \
    --set 'Time/Integrator=implicit' --set 'Time/Step rule=fixed' \
    --set 'Time/Step size=0.0125' --set 'Time/End time=12.5' \
    --set "Method/Geometry=$geometry" --set 'Output/Frames=0' --set 'Output/Pictures=false'
  check "$geometry: it runs" [ "$status" -eq 0 ]
  moves=$(largest kinetic_energy $geometry/ledger.csv)
  echo "$geometry: kinetic energy at most $moves J, stored $stored J"
  check "$geometry: 1000 steps" is "$(last step $geometry/ledger.csv) == 1000"
  check "$geometry: it stays at rest" is "$moves <= 1e-10 * $stored && $stored > 3000"
  check "$geometry: with the energy that was stored" \
    is "($(last strain_energy $geometry/ledger.csv) - $stored)^2 < (1e-9 * $stored)^2"
done

finish
