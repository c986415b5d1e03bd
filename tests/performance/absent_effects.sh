#!/bin/sh
# What effects cost a scene that does not name them: instructions per particle
# and step of an elastic body in emmy, against those in a program whose
# libraries have nothing else than Hencky (tests/absence/elastic_program.cc).
# Two runs of different length are subtracted, so that the start does not count.
# Counts need no quiet machine and repeat to some 0.01 %. Fails above 1 %. Takes
# two minutes or more.
#
#   tests/performance/absent_effects.sh [BUILD_FOLDER]      default: build
#
# The build folder has emmy and tests/test_elastic_program. Counts are those of
# valgrind: apt-get install valgrind.
set -eu

build=$(cd "${1:-build}" && pwd)
for program in "$build/emmy" "$build/tests/test_elastic_program"; do
  [ -x "$program" ] || { echo "no $program: build it first, with EMMY_TESTS=ON" >&2; exit 2; }
done
. "$(dirname "$0")/scratch.sh"
need_valgrind
cd "$work"

few=4
many=12
limit=1 # %

# scene DIMENSION CELLS: a block of CELLS^DIMENSION cells, at four particles
# per direction and cell in the plane, two in space, that spins and stretches
scene()
{
  awk -v dim="$1" -v n="$2" '
    function all(value, separator,   i, list)
    {
      list = value
      for (i = 1; i < dim; ++i)
        list = list separator value
      return list
    }
    BEGIN {
      middle = n / 2 + 2
      print "set Dimension = " dim
      print "subsection Method\nset Shape functions = linear\nset Starved nodes = free\nend"
      print "subsection Grid\nset Lower corner = " all(0, ", ")
      print "set Upper corner = " all(n + 4, ", ") "\nset Cells = " all(n + 4, ", ") "\nend"
      print "subsection Materials\nset Names = rubber\nsubsection rubber"
      print "set Model = Hencky\nset Density = 5\nset Young'"'"'s modulus = 100"
      print "set Poisson'"'"'s ratio = 0.3\nend\nend"
      print "subsection Bodies\nset Names = block\nsubsection block\nset Shape = box"
      print "set Material = rubber\nset Points per direction = " (dim == 2 ? 4 : 2)
      print "set Initial velocity = 0.1*(x - " middle ") - 0.05*(y - " middle ");" \
            " 0.05*(x - " middle ") - 0.1*(y - " middle ")" (dim == 2 ? "" : "; 0")
      print "subsection box\nset Lower corner = " all(2, ", ")
      print "set Upper corner = " all(n + 2, ", ") "\nend\nend\nend"
      print "subsection Time\nset End time = 1e3\nset Step rule = fixed"
      print "set Step size = 0.05\nend"
      print "subsection Output\nset Frames = 0\nset Pictures = false\nend"
    }'
}

# instructions PROGRAM SCENE STEPS: of a whole run
instructions()
{
  valgrind --tool=callgrind --callgrind-out-file=counts "$1" "$2" \
    --set "Time/Maximum steps=$3" --set Output/Directory=run --overwrite \
    >out 2>err </dev/null || { cat out err >&2; exit 1; }
  awk '/^(summary|totals):/ { print $2; exit }' counts
}

# per_step PROGRAM SCENE PARTICLES: instructions per particle and step
per_step()
{
  short=$(instructions "$1" "$2" $few)
  long=$(instructions "$1" "$2" $many)
  awk -v a="$short" -v b="$long" -v steps=$((many - few)) -v n="$3" \
    'BEGIN { printf "%.1f\n", (b - a) / steps / n }'
}

echo "| elastic block | particles | emmy | only the elastic lines | more |"
echo "|---|---|---|---|---|"
status=0
for dim in 2 3; do
  cells=$([ $dim = 2 ] && echo 10 || echo 4)
  scene $dim "$cells" >scene.prm
  particles=$([ $dim = 2 ] && echo $((16 * cells * cells)) || echo $((8 * cells * cells * cells)))
  all=$(per_step "$build/emmy" scene.prm "$particles")
  elastic=$(per_step "$build/tests/test_elastic_program" scene.prm "$particles")
  more=$(awk -v a="$all" -v b="$elastic" 'BEGIN { printf "%.3f\n", 100 * (a / b - 1) }')
  echo "| ${dim}D, linear | $particles | $all | $elastic | $more % |"
  awk -v more="$more" -v limit=$limit 'BEGIN { exit !(more <= limit) }' || status=1
done
[ $status = 0 ] || echo "FAILED: more than $limit %"
exit $status
