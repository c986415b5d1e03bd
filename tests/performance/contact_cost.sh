#!/bin/sh
# What contact costs where less than 10 % of the particles touch: instructions of
# an iteration of Newton, and of a step, against those of the same scene without
# contact: one body in place of two, a side of the grid in place of the tool.
#   tools     a block on a side that only pushes
#   fields    two blocks with velocities of their own that go through one another:
#             what doubled nodes cost
#   pairs     two blocks that meet: they begin where points begin to reach
#   overlap   two blocks that begin face to face, nearer than points reach: in the
#             first step they push one another apart with far more than the
#             kinetic energy there is
#   fine ...  with cells of half the size, and 4 % of the particles that meet
# Two runs of different length are subtracted, so that the start does not count.
# Counts need no quiet machine. Fails if an iteration costs more than 15 % more,
# but for the overlap. Takes four minutes.
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
    overlap | fields)
      echo "set Names = lower, upper"
      body lower 0 1.5
      body upper 1.5 3
      ;;
    pairs) # points reach 0.75 of the spacing of the particles beyond faces
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
    fields | pairs | overlap)
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

status=0
# row NAME WHAT: against $none
row()
{
  with=$(costs "$2")
  awk -v name="$1" -v what="$2" -v a="${with% *}" -v n="${with#* }" -v b="${none% *}" \
    -v m="${none#* }" -v limit=$limit 'BEGIN {
      more = 100 * (a / b - 1)
      printf "| %s | %d | %s | %.1f %% | %.1f %% |\n", name, a, n, more,
        100 * (a * n / (b * m) - 1)
      exit !(more <= limit || what == "overlap") }' || status=1
}

echo "| 768 particles, 32 touch the tool, 64 meet | instructions per iteration of Newton | iterations per step | more, per iteration | more, per step |"
echo "|---|---|---|---|---|"
none=$(costs none)
echo "| no contact | ${none% *} | ${none#* } | | |"
for what in tools fields pairs overlap; do
  row $what $what
done
cells=32
none=$(costs none)
echo "| fine, no contact | ${none% *} | ${none#* } | | |"
row "fine, pairs" pairs
[ $status = 0 ] || echo "FAILED: more than $limit %"
exit $status
