#!/bin/sh
# How many particles explicit steps (Time/Integrator = explicit) update per
# second of one core: all of a step counts, from sorting to the row of the
# ledger. Two runs of different length are subtracted, so that the start does
# not count; seconds are those of the processor (user and system), so that
# other programs disturb little; of several repetitions the best is taken.
#
#   tests/performance/explicit_speed.sh [BUILD_FOLDER] [REPETITIONS]
#
# The build folder (default: build) has emmy. Fails if trilinear functions with
# 8 particles per cell and an elastic material come to less than 1e6. Four
# minutes.
set -eu

emmy=$(cd "${1:-build}" && pwd)/emmy
repetitions=${2:-3}
[ -x "$emmy" ] || { echo "no $emmy: build it first" >&2; exit 2; }
. "$(dirname "$0")/scratch.sh"
cd "$work"

few=5
many=45
wanted=1e6

# scene DIMENSION CELLS VELOCITY: a block of CELLS^DIMENSION cells of 1 m that
# shears, stretches and flies with VELOCITY
scene()
{
  awk -v dim="$1" -v n="$2" -v flight="$3" '
    function all(value, separator,   i, list)
    {
      list = value
      for (i = 1; i < dim; ++i)
        list = list separator value
      return list
    }
    BEGIN {
      middle = n / 2 + 4
      print "set Dimension = " dim
      print "subsection Method\nset Shape functions = linear\nset Starved nodes = free\nend"
      print "subsection Grid\nset Lower corner = " all(0, ", ")
      print "set Upper corner = " all(n + 12, ", ") "\nset Cells = " all(n + 12, ", ") "\nend"
      print "subsection Materials\nset Names = m\nsubsection m\nset Model = Hencky"
      print "set Density = 5\nset Young'"'"'s modulus = 100\nset Poisson'"'"'s ratio = 0.3"
      print "end\nend\nsubsection Bodies\nset Names = block\nsubsection block"
      print "set Shape = box\nset Material = m\nset Points per direction = 2"
      print "set Initial velocity = " flight " + 0.004*(x - " middle ") - 0.002*(y - " middle ");" \
            " 0.002*(x - " middle ") - 0.004*(y - " middle ")" (dim == 2 ? "" : "; 0")
      print "subsection box\nset Lower corner = " all(4, ", ")
      print "set Upper corner = " all(n + 4, ", ") "\nend\nend\nend"
      print "subsection Time\nset Integrator = explicit\nset End time = 1e9"
      print "set Step rule = normalised\nset Factor = 0.2\nend"
      print "subsection Output\nset Frames = 0\nset Pictures = false\nset Directory = out\nend"
    }'
}

# seconds STEPS OPTIONS...: of the processor
seconds()
{
  steps=$1
  shift
  (
    "$emmy" scene.prm --overwrite --set "Time/Maximum steps=$steps" "$@" >log 2>&1
    times >used
  ) || { tail -n 5 log >&2; exit 1; }
  tail -n 1 used | tr ms '  ' | awk '{ print 60 * $1 + $2 + 60 * $3 + $4 }'
}

# measure NAME OPTIONS...: a line of the table; sets rate
measure()
{
  name=$1
  shift
  best=
  for _ in $(seq "$repetitions"); do
    short=$(seconds $few "$@")
    long=$(seconds $many "$@")
    best=$(awk -v a="$short" -v b="$long" -v best="$best" \
      'BEGIN { d = b - a; print (best == "" || d < best) ? d : best }')
  done
  particles=$(awk '/^  particles / { print $2 + 0 }' out/run.log)
  rate=$(awk -v n="$particles" -v s="$best" -v k=$((many - few)) 'BEGIN { printf "%.3g", n * k / s }')
  printf '| %s | %s | %s |\n' "$name" "$particles" "$rate"
}

echo "| scene | particles | updates per second |"
echo "|---|---|---|"
scene 3 24 0 >scene.prm
measure "3D, linear, elastic"
elastic=$rate
measure "the same, plain stress update" --set "Time/Stress update=plain"
measure "the same, von Mises" --set "Materials/m/Model=von Mises" \
  --set "Materials/m/Yield stress=1" --set "Materials/m/Hardening modulus=10"
measure "the same, GIMP" --set "Method/Shape functions=GIMP"
scene 3 24 0.5 >scene.prm
measure "3D, linear, elastic, in flight"
scene 3 48 0 >scene.prm
measure "3D, linear, elastic, larger"
scene 2 160 0 >scene.prm
measure "2D, linear, elastic"
awk -v rate="$elastic" -v wanted=$wanted 'BEGIN { exit !(rate >= wanted) }' ||
  { echo "less than $wanted updates per second" >&2; exit 1; }
