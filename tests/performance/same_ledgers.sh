#!/bin/sh
# Whether two builds make the same ledgers, bit for bit: for changes that move
# code and must not move a number. Some steps of the paper's scenes, of two balls
# and a shaken block, and of each remedy and mapping; with the geometry of the
# start where nothing else is said. Takes a minute.
#
#   tests/performance/same_ledgers.sh BUILD_FOLDER OTHER_BUILD_FOLDER
set -eu

[ $# -eq 2 ] || { echo "usage: same_ledgers.sh BUILD_FOLDER OTHER_BUILD_FOLDER" >&2; exit 2; }
root=$(cd "$(dirname "$0")/../.." && pwd)
one=$(cd "$1" && pwd)/emmy
other=$(cd "$2" && pwd)/emmy
for program in "$one" "$other"; do
  [ -x "$program" ] || { echo "no $program: build it first" >&2; exit 2; }
done
. "$(dirname "$0")/scratch.sh"
cd "$work"
status=0

# compare FILE STEPS SETTINGS...
compare()
{
  file=$1
  steps=$2
  shift 2
  for setting; do
    shift
    set -- "$@" --set "$setting"
  done
  for program in "$one" "$other"; do
    rm -rf run
    "$program" "$root/prm/$file" --set "Time/Maximum steps=$steps" "$@" \
      --set Output/Directory=run --set Output/Frames=0 \
      --set Output/Pictures=false >out 2>&1 || { cat out >&2; exit 1; }
    mv run/ledger.csv "$([ "$program" = "$one" ] && echo one || echo other)"
  done
  verdict=same
  cmp -s one other || { verdict=DIFFERENT; status=1; }
  echo "$verdict: $file, $(($(wc -l <one) - 2)) steps $*" | sed 's/ --set//g'
}

for scene in 7.1a 7.1b 7.2; do
  compare paper/$scene.prm 12
done
for scene in 7.3a 7.3b 7.4; do
  compare paper/$scene.prm 6
done
at_start='Method/Geometry=start'
compare validation/two-balls.prm 6 "$at_start"
compare examples/shaken-block.prm 20 "$at_start"
compare examples/shaken-block.prm 20 Time/Integrator=explicit "$at_start" \
  'Method/Starved nodes=free' Time/Factor=0.3
compare validation/vibration.prm 5 "$at_start"
compare paper/7.2.prm 8 'Effects/Names=ghost stabilisation'
compare paper/7.2.prm 8 'Method/Starved nodes=follow'
compare paper/7.1a.prm 8 Method/Mapping=blend 'Method/FLIP fraction=0.9' \
  Method/Lumping=0.3
for walls in inelastic unconstrained; do
  compare paper/7.1a.prm 8 "Method/Wall mapping=$walls"
done
compare paper/7.2.prm 8 'Method/Shape functions=GIMP' Method/Geometry=middle \
  'Method/Starved nodes=follow'
exit $status
