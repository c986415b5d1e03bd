#!/bin/sh
# What the geometry of the middle costs: seconds of a step with
# Method/Geometry = middle over those with start, and iterations, where start is
# healthy. Runs alternate; the median of five ratios is printed. Needs an idle
# machine; a minute or two.
#
#   tests/performance/middle_geometry.sh [BUILD_FOLDER]      default: build
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "${1:-build}" && pwd)
[ -x "$build/emmy" ] || { echo "no $build/emmy: build it first" >&2; exit 2; }
. "$(dirname "$0")/scratch.sh"
cd "$work"

# once GEOMETRY FILE SETTINGS...: seconds of the run without its setup
once()
{
  geometry=$1
  file=$2
  shift 2
  "$build/emmy" "$root/prm/$file" --set "Method/Geometry=$geometry" \
    --set Output/Directory=run --set Output/Frames=0 \
    --set Output/Pictures=false --overwrite "$@" >out
  awk '$1 == "setup" { setup = $3 } /^total wall time/ { total = $4 }
       END { print total - setup }' out >"$geometry.seconds"
  awk -F, '/^#/ { next } !column { for (i = 1; i <= NF; ++i)
             if ($i == "newton_iterations") column = i; next }
           $1 > 0 { sum += $column; ++n } END { printf "%.2f\n", sum / n }' \
    run/ledger.csv >"$geometry.iterations"
}

# compare NAME FILE SETTINGS...
compare()
{
  name=$1
  shift
  : >ratios
  for repetition in 1 2 3 4 5; do
    once start "$@"
    once middle "$@"
    echo "$(cat middle.seconds) $(cat start.seconds)" |
      awk '{ print $1 / $2 }' >>ratios
  done
  printf '| %s | %.2f | %s | %s |\n' "$name" "$(sort -n ratios | sed -n 3p)" \
    "$(cat start.iterations)" "$(cat middle.iterations)"
}

echo '| scene | middle / start | iterations, start | middle |'
echo '|---|---|---|---|'
compare 'column in a tube, to 10 s' validation/slow-column.prm \
  --set 'Time/End time=10'
compare '7.2, h = 0.5 m, 2 x 2 points' paper/7.2.prm \
  --set 'Method/Shape functions=GIMP' --set 'Method/Starved nodes=follow' \
  --set 'Grid/Cells=40, 24' --set 'Bodies/left/Points per direction=2' \
  --set 'Bodies/right/Points per direction=2' --set 'Time/Step rule=fixed' \
  --set 'Time/Step size=0.06' --set 'Time/End time=8'
for n in 3 4 6; do
  compare "7.2, h = 2 m, $n x $n points" paper/7.2.prm \
    --set 'Method/Shape functions=GIMP' --set 'Method/Starved nodes=follow' \
    --set "Bodies/left/Points per direction=$n" \
    --set "Bodies/right/Points per direction=$n" --set 'Time/Step rule=fixed' \
    --set 'Time/Step size=0.03'
done
compare '7.3B, h = 0.5 m, 2 x 2 points' paper/7.3b.prm \
  --set 'Method/Starved nodes=follow' \
  --set 'Grid/Cells=40, 24' --set 'Bodies/left/Points per direction=2' \
  --set 'Bodies/right/Points per direction=2' --set 'Time/Step rule=fixed' \
  --set 'Time/Step size=0.06' --set 'Time/End time=8'
compare 'two balls in space, 2 x 2 x 2 points, 10 steps' \
  validation/two-balls.prm --set 'Method/Shape functions=GIMP' \
  --set 'Method/Starved nodes=follow' --set 'Time/Maximum steps=10' \
  --set 'Bodies/left/Points per direction=2' \
  --set 'Bodies/right/Points per direction=2'
