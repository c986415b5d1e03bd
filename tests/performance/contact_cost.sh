#!/bin/sh
# What contact costs where less than 10 % of the particles touch: instructions of
# an iteration of Newton of two blocks that lie on one another, and of a block on
# a tool, against those of the same scenes without contact: one body in place of
# two, a side of the grid in place of the tool. Two runs of different length are
# subtracted, so that the start does not count. Counts need no quiet machine.
# Fails above 15 %. Takes two minutes.
#
#   tests/performance/contact_cost.sh [BUILD_FOLDER]      default: build
#
# Counts are those of valgrind: apt-get install valgrind.
set -eu

build=$(cd "${1:-build}" && pwd)
[ -x "$build/emmy" ] || { echo "no $build/emmy: build it first" >&2; exit 2; }
. "$(dirname "$0")/scratch.sh"
need_valgrind
cd "$work"

few=1
many=3
limit=15 # %

# body NAME LOWER UPPER HEIGHTS: a block of 4 m width
body()
{
  echo "subsection $1"
  echo "set Shape = box"
  echo "set Material = rubber"
  echo "set Points per direction = 2"
  echo "set Initial velocity = 0; -0.01*y"
  echo "subsection box"
  echo "set Lower corner = 0, $2"
  echo "set Upper corner = 4, $3"
  echo "end"
  echo "end"
}

# scene WHAT: "none", "tools" (the lower side only pushes) or "pairs" (two blocks)
scene()
{
  echo "set Dimension = 2"
  echo "subsection Grid"
  echo "set Lower corner = 0, 0"
  echo "set Upper corner = 4, 4"
  echo "set Cells = 16, 16"
  echo "end"
  echo "subsection Materials"
  echo "set Names = rubber"
  echo "subsection rubber"
  echo "set Model = Hencky"
  echo "set Density = 5"
  echo "set Young's modulus = 100"
  echo "set Poisson's ratio = 0.3"
  echo "end"
  echo "end"
  echo "subsection Bodies"
  if [ "$1" = pairs ]; then
    echo "set Names = lower, upper"
    body lower 0 1.5
    body upper 1.5 3
  else
    echo "set Names = block"
    body block 0 3
  fi
  echo "end"
  echo "subsection Boundary conditions"
  if [ "$1" = tools ]; then
    echo "set Roller = x-min, x-max"
    echo "set Contact = y-min"
  else
    echo "set Roller = x-min, x-max, y-min"
  fi
  echo "end"
  echo "subsection Effects"
  if [ "$1" = pairs ]; then
    echo "set Names = contact"
    echo "subsection Contact"
    echo "set Groups = lower | upper"
    echo "set Friction coefficient = 0.3"
    echo "end"
  fi
  echo "end"
  echo "subsection Time"
  echo "set End time = 1e3"
  echo "set Step rule = fixed"
  echo "set Step size = 0.05"
  echo "end"
  echo "subsection Output"
  echo "set Frames = 0"
  echo "set Pictures = false"
  echo "end"
}

# counted WHAT STEPS: instructions and iterations of Newton of a whole run
counted()
{
  valgrind --tool=callgrind --callgrind-out-file=/dev/null --log-file=counts \
    "$build/emmy" "$1.prm" --set "Time/Maximum steps=$2" \
    --set Output/Directory=run --overwrite >out 2>&1 || { cat out >&2; exit 1; }
  awk '/Collected/ { print $4 }' counts
  awk -F, '!c { for (i = 1; i <= NF; ++i) if ($i == "newton_iterations") c = i; next }
           { n += $c } END { print n }' run/ledger.csv
}

# costs WHAT: instructions of an iteration, and iterations of a step
costs()
{
  scene "$1" >"$1.prm"
  { counted "$1" $few; counted "$1" $many; } | awk -v steps=$((many - few)) '
    { v[NR] = $1 }
    END { n = v[4] - v[2]; if (!(n > 0)) { print "no iterations counted" > "/dev/stderr"; exit 1 }
          printf "%.0f %.1f\n", (v[3] - v[1]) / n, n / steps }'
}

none=$(costs none)
status=0
echo "| 768 particles, 32 touch the tool, 64 meet | instructions per iteration of Newton | iterations per step | more, per iteration |"
echo "|---|---|---|---|"
echo "| no contact | ${none% *} | ${none#* } | |"
for what in tools pairs; do
  with=$(costs $what)
  awk -v what=$what -v a="${with% *}" -v n="${with#* }" -v b="${none% *}" -v limit=$limit 'BEGIN {
    more = 100 * (a / b - 1)
    printf "| %s | %d | %s | %.1f %% |\n", what, a, n, more
    exit !(more <= limit) }' || status=1
done
[ $status = 0 ] || echo "FAILED: more than $limit %"
exit $status
