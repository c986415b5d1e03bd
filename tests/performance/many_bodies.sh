#!/bin/sh
# What it costs to have many bodies: 100, 400 and 1600 small discs in a lattice,
# 2 x 2 particles a cell, with followers, for five steps. Prints the table of
# doc/performance.md: particles, seconds of the processor to read the file and
# for all of the run, wall seconds of setup and, per step, of aggregation. All
# should grow with the number of bodies.
#
#   tests/performance/many_bodies.sh [EMMY]      default: build/emmy
set -eu

emmy=${1:-build/emmy}
[ -x "$emmy" ] || { echo "no $emmy: build it first" >&2; exit 2; }
emmy=$(cd "$(dirname "$emmy")" && pwd)/$(basename "$emmy")
. "$(dirname "$0")/scratch.sh"
cd "$work"

# scene N: N x N discs, which move to the right, each in 4 x 4 cells
scene()
{
  awk -v n="$1" 'BEGIN {
    print "set Dimension = 2"
    print "subsection Grid\nset Lower corner = 0, 0\nset Upper corner = " 4*n ", " 4*n
    print "set Cells = " 4*n ", " 4*n "\nend"
    print "subsection Materials\nset Names = rubber\nsubsection rubber"
    print "set Model = Hencky\nset Density = 5\nset Young'"'"'s modulus = 100"
    print "set Poisson'"'"'s ratio = 0.3\nend\nend"
    print "subsection Bodies"
    for (i = 0; i < n * n; ++i) {
      names = names (i ? ", " : "") "disc " i
      print "subsection disc " i "\nset Shape = ball\nset Material = rubber"
      print "set Points per direction = 2\nset Initial velocity = 0.1; 0"
      print "subsection ball\nset Center = " 4*(i%n) + 2.3 ", " 4*int(i/n) + 1.9
      print "set Radius = 1\nend\nend"
    }
    print "set Names = " names "\nend"
    print "subsection Method\nset Shape functions = linear\nend"
    print "subsection Time\nset End time = 1\nset Step rule = fixed"
    print "set Step size = 0.05\nset Maximum steps = 5\nend"
    print "subsection Output\nset Directory = run\nset Overwrite = true"
    print "set Frames = 0\nset Pictures = false\nend"
  }'
}

# processor_seconds COMMAND...: user and system
processor_seconds()
{
  ("$@" >out 2>&1 || { cat out >&2; exit 1; }; times) | awk '
    NR == 2 { for (i = 1; i <= 2; ++i) { split($i, t, "[ms]"); sum += 60*t[1] + t[2] }
              printf "%.2f\n", sum }'
}

# of PHASE KEY: a number of timing.json, where each entry has its line
of()
{
  awk -v name="\"name\": \"$1\"" -v key="\"$2\": " '
    index($0, name) { is_there = 1 }
    is_there && index($0, key) { sub(/^[^:]*: /, ""); print $0 + 0; exit }' run/timing.json
}

echo "| discs | particles | reading, s | run, s | setup, s | aggregation, s/step |"
echo "|---|---|---|---|---|---|"
for n in 10 20 40; do
  scene $n >scene.prm
  reading=$(processor_seconds "$emmy" --print-parameters scene.prm)
  run=$(processor_seconds "$emmy" scene.prm)
  particles=$(tail -n 1 run/ledger.csv | tr , '\n' | sed -n "$(
    head -n 1 run/ledger.csv | tr , '\n' | grep -n '^particles$' | cut -d : -f 1
  )p")
  setup=$(of setup seconds)
  aggregation=$(of aggregation seconds)
  calls=$(of aggregation calls)
  awk -v discs=$((n * n)) -v particles="$particles" -v reading="$reading" -v run="$run" \
    -v setup="$setup" -v aggregation="$aggregation" -v calls="$calls" 'BEGIN {
      printf "| %d | %d | %.2f | %.2f | %.3f | %.4f |\n",
        discs, particles, reading, run, setup, aggregation / calls }'
done
