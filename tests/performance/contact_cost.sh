#!/bin/sh
# What contact costs where less than 10 % of the particles touch: instructions of
# an iteration of Newton, and of a step, against those of the same scene without
# contact: a side of the grid in place of the tool; two blocks whose nodes are one
# in place of two that push.
#   tools   a block on a side that only pushes
#   fields  two blocks with velocities of their own that go through one another:
#           what doubled nodes cost
#   pairs   two blocks that meet: they begin where points begin to reach. Slow: so
#           slow that all but contact is linear, and contact takes Newton one
#           iteration more. Faster: as many with contact as without. Fine: with
#           cells and steps of half the size half the share of particles meets
# Two runs of different length are subtracted, so that the start does not count.
# Counts need no quiet machine. Fails if a step costs more than 15 % more, or a
# slow one with its iteration more than it did when this was written. Takes two
# minutes on idle cores.
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
cells=16
speed=0.01 # of the blocks, in m/s at the height of 1 m
step=0.05  # s

# body NAME LOWER UPPER HEIGHTS: a block of 4 m width
body()
{
  echo "subsection $1"
  echo "set Shape = box"
  echo "set Material = rubber"
  echo "set Points per direction = 2"
  echo "set Initial velocity = 0; -$speed*y"
  echo "subsection box"
  echo "set Lower corner = 0, $2"
  echo "set Upper corner = 4, $3"
  echo "end"
  echo "end"
}

# scene WHAT: of the list above, or "none"; with $cells along the blocks
scene()
{
  echo "set Dimension = 2"
  echo "subsection Grid"
  echo "set Lower corner = 0, 0"
  echo "set Upper corner = 4, 4"
  echo "set Cells = $cells, $cells"
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
  case "$1" in
    fields)
      echo "set Names = lower, upper"
      body lower 0 1.5
      body upper 1.5 3
      ;;
    pairs | joined) # points reach 0.75 of the spacing of the particles beyond faces
      echo "set Names = lower, upper"
      gap=$(awk -v n="$cells" 'BEGIN { print 0.72 * 2 / n }')
      body lower 0 1.5
      body upper "$(awk -v g="$gap" 'BEGIN { print 1.5 + g }')" \
        "$(awk -v g="$gap" 'BEGIN { print 3 + g }')"
      ;;
    *)
      echo "set Names = block"
      body block 0 3
      ;;
  esac
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
  case "$1" in
    fields | pairs)
      echo "set Names = contact"
      echo "subsection Contact"
      echo "set Groups = lower | upper"
      if [ "$1" = fields ]; then
        echo "set Stiffness factor = 0"
      else
        echo "set Friction coefficient = 0.3"
      fi
      echo "end"
      ;;
  esac
  echo "end"
  echo "subsection Time"
  echo "set End time = 1e3"
  echo "set Step rule = fixed"
  echo "set Step size = $step"
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

status=0
# row NAME WHAT REFERENCE LIMIT: a step may cost so many % more than one of the
# reference, "INSTRUCTIONS ITERATIONS"
row()
{
  with=$(costs "$2")
  awk -v name="$1" -v a="${with% *}" -v n="${with#* }" -v b="${3% *}" -v m="${3#* }" \
    -v limit="$4" 'BEGIN {
      more = 100 * (a * n / (b * m) - 1)
      printf "| %s | %d | %s | %.1f %% | %.1f %% |\n", name, a, n, 100 * (a / b - 1), more
      exit !(more <= limit) }' || { echo "FAILED: more than $4 % a step"; status=1; }
}

# without NAME WHAT: of no contact; sets $reference
without()
{
  reference=$(costs "$2")
  echo "| $1 | ${reference% *} | ${reference#* } | | |"
}

echo "| 768 particles, 32 touch the tool, 64 meet | instructions per iteration of Newton | iterations per step | more, per iteration | more, per step |"
echo "|---|---|---|---|---|"
without "a block" none
row "tools" tools "$reference" 15
row "fields" fields "$reference" 15
without "two blocks, joined, slow" joined
row "slow, pairs" pairs "$reference" 36
speed=0.1
many=4
without "two blocks, joined, faster" joined
row "faster, pairs" pairs "$reference" 15
cells=32
step=0.025
without "fine: 3072 particles, 128 meet" joined
row "fine, pairs" pairs "$reference" 15
exit $status
