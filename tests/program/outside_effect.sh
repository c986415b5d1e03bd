#!/bin/sh
# The worked example of doc/extending.md, an effect outside emmy, built as its
# user would: its own test passes, its scene runs and balances, messages know it.
#
# Usage: outside_effect.sh BUILD_FOLDER SOURCE_ROOT CMAKE MPI_LAUNCHER
set -u

[ $# -eq 4 ] || { echo "usage: outside_effect.sh BUILD_FOLDER SOURCE_ROOT CMAKE MPI_LAUNCHER" >&2; exit 2; }
# shellcheck source=tests/program/checks.sh
. "$2/tests/program/checks.sh"
build=$(absolute "$1")
example=$(absolute "$2")/doc/examples/mass-damping
cmake=$3
launcher=$4
cd "$work" || exit 2

built 'configure' -S "$example" -B outside -Demmy_DIR="$build"
built 'build' --build outside

emmy=$work/outside/test_mass_damping
emmy_run "$example/damped-block.prm"
check 'its test passes' [ "$status" -eq 0 ]
cat out

emmy=$work/outside/mass-damping
emmy_run "$example/damped-block.prm" --set 'Output/Directory=block'
check 'its scene runs' [ "$status" -eq 0 ]
check 'its scene runs without complaint' [ ! -s err ]
check 'its column is where those of effects are' [ "$(columns block)" = strain_energy,damping_loss ]
# the largest relative change of what should be constant
change=$(awk -F , '
  NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
  { energy = $column["kinetic_energy"] + $column["strain_energy"] + $column["damping_loss"] }
  NR == 2 { initial = energy }
  { change = energy / initial - 1
    if (change < 0) change = -change
    if (change > largest) largest = change }
  END { print largest, (NR == 18 && $column["damping_loss"] > 0.1 * initial && largest < 1e-12) }
' block/ledger.csv)
echo "kinetic + strain energy + damping_loss change by ${change% *} of it"
check 'kinetic + strain energy + damping_loss is constant' [ "${change#* }" = 1 ]
check 'the screen tells the loss' matches out '^    damping_loss +0\.'
check 'and the price' matches out '^mass damping +[1-9]'

sed -e 's/Dimension = 2/Dimension = 3/' -e 's/= 0, 0$/= 0, 0, 0/' \
  -e 's/= 6, 6$/= 6, 6, 6/' -e 's/= 2.25, 2.25$/= 2.25, 2.25, 2.25/' \
  -e 's/= 3.75, 3.75$/= 3.75, 3.75, 3.75/' -e '/Initial velocity/s/$/; 0/' \
  "$example/damped-block.prm" >space.prm
emmy_run space.prm --set 'Time/Maximum steps=2' --set 'Output/Directory=space'
check 'it runs in three dimensions' [ "$status" -eq 0 ]
check 'and loses' is "$(last space damping_loss) > 0.1"

# a body that both ranks hold
set -- "$example/damped-block.prm" --set 'Bodies/block/box/Lower corner=1.25, 1.25' \
  --set 'Bodies/block/box/Upper corner=4.75, 4.75' --set 'Time/Maximum steps=3'
emmy_run "$@" --set 'Output/Directory=one'
run_on_two_ranks "$@" --set 'Output/Directory=two'
check 'it runs on two ranks' [ "$status" -eq 0 ]
check 'both have a part of the body' matches two/particles_0001.1.vtu 'NumberOfPoints="[1-9]'
check 'they lose what one loses' \
  is "($(last two damping_loss) / $(last one damping_loss) - 1)^2 < 1e-24"

emmy_run "$example/damped-block.prm" --set 'Effects/Mass damping/Rate=0'
check 'no rate is an error' [ "$status" -eq 1 ]
check 'the message says what to do' says err 'it is required and must be positive (1/s)'
emmy_run "$example/damped-block.prm" --set 'Effects/Names=mass dumping'
check 'a misspelt name is an error' says err 'did you mean <mass damping>?'
emmy_run "$example/damped-block.prm" --set 'Effects/Names=' --set 'Output/Directory=free'
check 'not named: no column' [ "$(columns free)" = strain_energy ]
check 'not named: one line in the log' says free/run.log \
  'section Effects/Mass damping is not used, because Effects/Names does not list <mass damping>'
emmy_run --list
check 'the list of what there is has it' \
  has_lines 1 out '^  mass damping +a force proportional to mass and velocity$'
emmy_run --check "$example/damped-block.prm"
check 'the scene card has it' matches out '^    mass damping +0 +0  Newton: mass times velocity$'
check 'the scene card has its column' matches out 'damping_loss'
emmy_run --print-parameters
check 'the reference of parameters has it' matches out 'subsection Mass damping'

finish
