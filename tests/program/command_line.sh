#!/bin/sh
# The command line does what its help says, and a run leaves the results that
# it should. The scenes that come with emmy are run by scenes.py.
#
# Usage: command_line.sh EMMY SOURCE_ROOT MPI_LAUNCHER
set -u

[ $# -eq 3 ] || { echo "usage: command_line.sh EMMY SOURCE_ROOT MPI_LAUNCHER" >&2; exit 2; }
# shellcheck source=tests/program/checks.sh
. "$2/tests/program/checks.sh"
emmy=$(absolute "$1")
root=$(absolute "$2")
cd "$work" || exit 2
mkdir run && cd run || exit 2 # output of emmy goes beside it
tiny_scene >base.prm

# accepted NAME ARGUMENTS...: emmy succeeds, and complains of nothing
accepted()
{
  name=$1
  shift
  emmy_run "$@"
  check "$name: exit code 0" [ "$status" -eq 0 ]
  check "$name: no complaint" [ ! -s "$work/err" ]
}

# prints NAME ARGUMENTS...: the same, and it writes nothing
prints()
{
  before=$(state .)
  accepted "$@"
  check "$name: nothing is written" [ "$(state .)" = "$before" ]
}

# sets ENTRY VALUE: what emmy just printed sets an entry to this value
sets()
{
  matches "$work/out" "^ *set $1 += $2 *(#.*)?\$"
}


echo "Help"
prints '--help' --help
for word in --set --overwrite --check --print-parameters --version FILE.prm; do
  check "--help: names $word" says "$work/out" "$word"
done
cp "$work/out" ../help
prints '-h' -h
check '-h: is --help' cmp -s "$work/out" ../help
prints '--version' --version
check '--version: one line with the number' \
  has_lines 1 "$work/out" '^emmy [0-9]+\.[0-9]+\.[0-9]+$'
check '--version: nothing else' has_lines 1 "$work/out"
prints '--help with a file' --help base.prm
check '--help with a file: is --help' cmp -s "$work/out" ../help
prints '--help of a section' --help effects
check '--help of a section: the effects that there are' has_lines 1 "$work/out" '^  gravity  +[^ ].{9}'
check '--help of a section: and no materials' not says "$work/out" Hencky
check '--help of a section: its entries' sets Acceleration ''
check '--help of a section: no others' not sets 'Step size' '.*'
prints '--help of an entry' '--help=step size'
check '--help of an entry: where it stands' has_lines 1 "$work/out" '^Time/Step size$'
check '--help of an entry: what it is' has_lines 1 "$work/out" '^ *# .*Unit: s\.'
check '--help of an entry: nothing else' has_lines 3 "$work/out"
prints '--help of tools, which share entries' --help tools
check '--help of tools: what they share is said once' has_lines 1 "$work/out" "mu of Coulomb's law"
check '--help of tools: each has it' has_lines 6 "$work/out" 'set Friction coefficient = 0'
check '--help of tools: it says so' says "$work/out" 'as those of the same name above'
prints '--help of a word: no section or entry has that name' --help ground
check '--help of a word: entries that speak of it' has_lines 1 "$work/out" '^Bodies/.*/K0$'
check '--help of a word: what they say' has_lines 1 "$work/out" 'Of level ground: the horizontal over'
prints '--help of a word: static' --help static
check '--help of a word: the integrator' has_lines 1 "$work/out" '^Time/Integrator$'
prints '--help of a study' study --help Names
check '--help of a study: its entry' has_lines 1 "$work/out" '^Study/Names$'

echo "Completion"
prints 'completion' completion bash
cp "$work/out" ../completion
if command -v bash >/dev/null; then
  # completed WORDS...: what bash offers for the last of them
  completed()
  {
    bash -c '. ../completion && COMP_WORDS=(emmy "$@") COMP_CWORD=$# && _emmy && echo "${COMPREPLY[*]}"' bash "$@"
  }
  check 'completion: an option' [ "$(completed base.prm --over)" = --overwrite ]
  check 'completion: each option of the help' [ "$(completed -- | wc -w)" -eq \
    "$(grep -c '^  \(-h .*\)\{0,1\}--' ../help)" ]
  check 'completion: a file' [ "$(completed --check ba)" = base.prm ]
  check 'completion: a study' [ "$(completed stu)" = study ]
fi

echo "Reference of the parameters"
prints '--print-parameters' --print-parameters
cp "$work/out" ../reference.prm
check 'reference: every entry has a comment above it' [ -z "$(
  awk '/^ *set / && last !~ /^ *#/ { print }
       { last = $0 }' ../reference.prm
)" ]
for section in Grid Materials Bodies 'Boundary conditions' Effects Method Time Solver Diagnosis Measurements Output; do
  check "reference: has section $section" matches ../reference.prm "^subsection $section\$"
done
prints 'the reference as a file' --print-parameters ../reference.prm
# but for the four lines at its head
tail -n +5 ../reference.prm >../reference_body.prm
check 'the reference as a file: is read back unchanged' cmp -s "$work/out" ../reference_body.prm
emmy_run --check ../reference.prm
check 'the reference as a scene: stops at a required value' [ "$status" -eq 1 ]
check 'the reference as a scene: names it' matches "$work/err" '<Grid/Cells> .* required'

echo "Values and --set"
prints 'parameters of a file' --print-parameters base.prm
check 'parameters of a file: its value' sets 'Step size' 0.125
check 'parameters of a file: a default' sets 'Maximum halvings' '[0-9]+'
prints '--set' --print-parameters base.prm --set 'Time/Step size=3' \
  --set 'Time/Factor=7' --set "Time/Step size = 4"
check '--set: overrides, and the last wins' sets 'Step size' 4
check '--set: another entry' sets 'Factor' 7
prints '--set before the file' --set 'Time/Step size=3' --print-parameters base.prm
check '--set before the file: overrides too' sets 'Step size' 3
prints '--set=' --print-parameters base.prm '--set=Time/Step size=3' --set 'Time/Factor=7'
check '--set=: overrides' sets 'Step size' 3
check '--set=: beside --set' sets 'Factor' 7
cp base.prm ./-base.prm
prints 'short, twice, and after --' --print --print-param --check --print-p --set=Time/Factor=7 -- -base.prm
rm ./-base.prm
check 'short, twice, and after --: the last task, the file' sets 'Factor' 7

# What `emmy --check` must tell, as fixed words separated by |
told='particles|cells|unknowns|bytes|first time step|memory of a run'

# tells NAME: what emmy printed has all that --check must tell
tells()
{
  wanted="$told|"
  while [ -n "$wanted" ]; do
    check "$1: tells ${wanted%%|*}" says "$work/out" "${wanted%%|*}"
    wanted=${wanted#*|}
  done
}

echo "Results of a run"
prints '--check' --check base.prm
tells '--check'
prints '--check --step' --check --step base.prm
check '--check --step: says how long it takes' has_lines 1 "$work/out" 'such steps take [0-9.e-]+ s$'
check '--check: counts the particles' matches "$work/out" '^ *particles +16[ ,]'
accepted 'tiny scene' base.prm --set 'Output/Directory=a/deep/folder'
here=a/deep/folder
for file in ledger.csv particles.pvd grid.pvd parameters.prm run.log timing.json; do
  check "results: $file" [ -s $here/$file ]
done
check 'results: no pictures unless wanted' [ ! -e $here/pictures ]
before_stress=step,time,time_step,kinetic_energy,kinetic_energy_grid_old,kinetic_energy_grid_new
after_works=residual_work,balance_error
counts=newton_iterations,linear_iterations,active_cells,active_dofs,particles,hidden_kinetic_energy,hidden_share,overfill
# header FOLDER: the names of the ledger's columns
header()
{
  head -n 1 "$1/ledger.csv"
}
check 'ledger: the columns of a plain scene' [ "$(header $here)" = \
  "$before_stress,strain_energy,$after_works,linear_momentum_x,linear_momentum_y,angular_momentum_z,$counts" ]
check 'ledger: the initial state and eight steps' has_lines 10 $here/ledger.csv
check 'ledger: row 0 is the initial state' \
  [ "$(sed -n 2p $here/ledger.csv | cut -d , -f 1-4)" = '0,0,0,2.5' ]
check 'ledger: as many numbers as names in each row' [ "$(
  awk -F , '{ print NF }' $here/ledger.csv | sort -u | wc -l
)" -eq 1 ]
check 'ledger: end time' [ "$(tail -n 1 $here/ledger.csv | cut -d , -f 1,2)" = '8,1' ]
check 'run.log: a line for each step' has_lines 8 $here/run.log '^step [0-9]+ '
check 'run.log: the seconds of each phase' matches $here/run.log '^total wall time'

# series_is_whole FILE.pvd FRAMES: so many frames, whose files are there
series_is_whole()
{
  [ "$(grep -c '<DataSet ' "$1")" -eq "$2" ] || return 1
  # shellcheck disable=SC2013 # names without blanks
  for file in $(sed -n 's/.* file="\([^"]*\)".*/\1/p' "$1"); do
    [ -s "$(dirname "$1")/$file" ] || return 1
  done
}
check 'particles.pvd: nine frames with their files' series_is_whole $here/particles.pvd 9
check 'grid.pvd: eight frames with their files' series_is_whole $here/grid.pvd 8

# is_json FILE: as far as the machine can tell
is_json()
{
  if python3 -c '' 2>/dev/null; then
    python3 -m json.tool "$1" >"$work/json"
  else
    [ "$(grep -o '{' "$1" | wc -l)" -eq "$(grep -o '}' "$1" | wc -l)" ]
  fi
}
check 'timing.json: is JSON' is_json $here/timing.json
check 'timing.json: names a phase' matches $here/timing.json '"residual and tangent"'

accepted 'other numbers of frames' base.prm --set 'Output/Directory=frames' \
  --set 'Output/Frames=2' --set 'Output/Grid files=false'
check 'two frames: particles at the start and twice' series_is_whole frames/particles.pvd 3
check 'two frames: no grid' [ ! -e frames/grid.pvd ]

echo "Digits and repetition"
# A block that stretches has numbers with all digits.
moving='Bodies/block/Initial velocity=0.3*sin(3*x) + 0.2*y; 0.2*cos(2*y)'
accepted 'stretching' base.prm --set "$moving" --set 'Output/Directory=first'
check 'ledger: 17 digits' [ "$(
  sed 1d first/ledger.csv | tr ',' '\n' | sed -e 's/e.*//' -e 's/[-.]//g' -e 's/^0*//' |
    awk '{ if (length($0) > longest) longest = length($0) } END { print longest }'
)" -eq 17 ]
check 'stretching: strain energy is not zero' [ "$(
  awk -F , 'END { print ($7 > 1e-6) }' first/ledger.csv
)" -eq 1 ]
check 'stretching: what solves left is told of' matches first/run.log \
  '^work of residuals .* J, of all steps without their signs '
check 'stretching: it does not matter' not says first/run.log 'what the solves left may matter'
accepted 'a loose tolerance' base.prm --set "$moving" --set 'Output/Directory=loose' \
  --set 'Solver/Newton tolerance=1e-2'
left=$(sed -n 's/^work of residuals .* signs \(.*\) J$/\1/p' loose/run.log)
check 'a loose tolerance: no step hides another' is "$left > 0 && $left >= 0.9999 * sqrt($(last loose residual_work)^2)"
check 'a loose tolerance: the work left may matter' says "$work/out" 'what the solves left may matter'
accepted 'components by , and ;' base.prm --set 'Output/Directory=separators' \
  --set 'Bodies/block/Initial velocity=if(x > 0, max(0.1, min(0.3, 2))*sin(3*x), 7) + 0.2*y, 0.2*cos(2*y)' \
  --set 'Grid/Lower corner=0; 0' --set 'Grid/Cells=4; 4' --set 'Bodies/block/box/Upper corner=2;2'
check 'components by , and ;: the same ledger, commas of functions count' cmp -s first/ledger.csv separators/ledger.csv
for separator in , \;; do
  accepted "a point load by $separator" base.prm --set 'Effects/Names=point load, gravity' \
    --set "Effects/Point load/Force=1$separator -2" --set 'Effects/Point load/Points nearest to=1, 1; 2, 2' \
    --set "Effects/Gravity/Acceleration=0$separator -9.81" --set "Boundary conditions/Fixed=y-min" \
    --set "Boundary conditions/Velocity of y-min=min(t, 0.1)$separator 0" --set 'Output/Directory=loaded' --overwrite
  [ "$separator" = , ] && cp loaded/ledger.csv by_comma.csv
done
check 'a point load, gravity and a moving wall: the same ledger' cmp -s by_comma.csv loaded/ledger.csv
accepted 'again from parameters.prm' first/parameters.prm --set 'Output/Directory=again'
check 'again from parameters.prm: the same ledger' cmp -s first/ledger.csv again/ledger.csv
# the same block as a formula, with and without a box around it
sed -e 's/= box/= expression/' -e 's/subsection box/subsection expression/' \
  -e 's/set Lower corner = 1, 1/set Expression = 0.5 - max(abs(x - 1.5), abs(y - 1.5))/' \
  -e '/set Upper corner = 2, 2/d' base.prm >formula.prm
corners=Bodies/block/expression
accepted 'formula' formula.prm --set "$moving" --set 'Output/Directory=formula'
check 'formula: the ledger of the box' cmp -s first/ledger.csv formula/ledger.csv
accepted 'formula with corners' formula.prm --set "$moving" --set 'Output/Directory=corners' \
  --set "$corners/Lower corner=0.9, 1" --set "$corners/Upper corner=3, 2"
check 'formula with corners: the same ledger' cmp -s first/ledger.csv corners/ledger.csv
prints 'formula cut by corners' --check formula.prm \
  --set "$corners/Lower corner=1.5, 0" --set "$corners/Upper corner=4, 4"
check 'formula cut by corners: half the particles' matches "$work/out" '^  particles +8,'
check 'formula cut by corners: no note' has_lines 0 "$work/out" 'note: its formula'
prints 'formula in a large grid' --check formula.prm \
  --set 'Grid/Upper corner=300, 300' --set 'Grid/Cells=300, 300'
check 'formula in a large grid: a note' \
  has_lines 1 "$work/out" 'note: its formula was tried in all 1.44e\+06 boxes'
prints 'formula with corners in a large grid' --check formula.prm \
  --set 'Grid/Upper corner=4000, 4000' --set 'Grid/Cells=4000, 4000' \
  --set "$corners/Lower corner=0.9, 1" --set "$corners/Upper corner=3, 2"
check 'formula with corners in a large grid: no note' \
  has_lines 0 "$work/out" 'note: its formula'
cat >unused.prm <<'END'
include base.prm
subsection Effects
  subsection Gravity
    set Acceleration = 0.3, -0.2
  end
end
END
accepted 'section of an effect without its name' unused.prm --set "$moving" \
  --set 'Output/Directory=unused'
check 'section of an effect without its name: the same ledger' \
  cmp -s first/ledger.csv unused/ledger.csv
check 'section of an effect without its name: the screen says so' \
  says "$work/out" 'note: section Effects/Gravity is not used, because Effects/Names does not list <gravity>'
accepted 'step size of another rule' base.prm --set 'Time/Step rule=wave' \
  --set 'Time/Maximum steps=1' --set 'Output/Directory=wave'
check 'step size of another rule: the screen says so' \
  says "$work/out" 'note: Time/Step size is not used, because Time/Step rule is <wave>'
check 'step size of its rule: no note' not says first/run.log 'note: Time/Step size'
accepted 'last step' base.prm --set 'Time/Step size=0.3' --set 'Output/Directory=cut'
check 'last step: it is shortened' [ "$(tail -n 1 cut/ledger.csv | cut -d , -f 1,2)" = '4,1' ]
check 'last step: nothing to say' not says cut/run.log 'after End time'
accepted 'last step beyond the end' base.prm --set 'Time/Step size=0.3' \
  --set 'Time/Shorten last step=false' --set 'Output/Directory=beyond'
check 'last step beyond the end: the screen says so' \
  says "$work/out" 'note: the run ended at t = 1.2 s, 0.2 s after End time'
accepted 'effect with its name' unused.prm --set "$moving" \
  --set 'Effects/Names=gravity' --set 'Output/Directory=used'
check 'effect with its name: another ledger' not cmp -s first/ledger.csv used/ledger.csv
check 'effect with its name: the column of its work' [ "$(header used)" = \
  "$before_stress,strain_energy,load_work,$after_works,linear_momentum_x,linear_momentum_y,angular_momentum_z,$counts" ]

echo "Diagnosis"
accepted 'diagnosis' base.prm --set "$moving" --set 'Diagnosis/Small cuts=true' \
  --set 'Diagnosis/Report above=1' --set 'Output/Directory=diagnosed'
check 'diagnosis: two columns more' [ "$(header diagnosed)" = "$(header first),mass_condition,jacobian_condition" ]
check 'diagnosis: all else is the same' [ "$(
  cut -d , -f 1-"$(header first | tr , '\n' | wc -l)" diagnosed/ledger.csv | cksum
)" = "$(cksum <first/ledger.csv)" ]
check 'diagnosis: run.log names places, for each matrix and step' \
  has_lines 16 diagnosed/run.log '^Step [0-9]+ .*: the scaled .* weakest at node'
check 'diagnosis: the screen does not' has_lines 0 "$work/out" 'weakest at node'
check 'diagnosis: the largest of the run' \
  has_lines 2 "$work/out" '^largest condition of the scaled .*, at step [1-8]$'
check 'diagnosis: its time' matches diagnosed/run.log '^diagnosis '
for field in mass_weakness jacobian_weakness; do
  check "diagnosis: $field in fields.txt" matches diagnosed/fields.txt "$field"
  check "diagnosis: $field only then" not matches first/fields.txt "$field"
done
check 'no diagnosis: no time' not matches first/run.log '^diagnosis '

echo "Three dimensions"
sed -e 's/Dimension = 2/Dimension = 3/' -e 's/= 0, 0$/= 0, 0, 0/' \
  -e 's/= 4, 4$/= 4, 4, 4/' -e 's/= 1; 0$/= 0; 0; 1/' -e 's/= 1, 1$/= 1, 1, 1/' \
  -e 's/= 2, 2$/= 2, 2, 2/' base.prm >space.prm
accepted 'three dimensions' space.prm --set 'Time/Maximum steps=2' \
  --set 'Output/Directory=space'
check 'three dimensions: the columns of the ledger' [ "$(header space)" = \
  "$before_stress,strain_energy,$after_works,linear_momentum_x,linear_momentum_y,linear_momentum_z,angular_momentum_x,angular_momentum_y,angular_momentum_z,$counts" ]

echo "Pictures"
if command -v gnuplot >/dev/null; then
  accepted 'with gnuplot' base.prm --set "$moving" --set 'Output/Pictures=true' \
    --set 'Output/Picture times=0, 1' --set 'Output/Directory=drawn'
  for picture in energies balance_error particles; do
    check "with gnuplot: $picture.png" [ -s drawn/pictures/$picture.png ]
  done
  check 'with gnuplot: no warning' has_lines 0 "$work/out" gnuplot
else
  echo "  no gnuplot here: pictures are not checked"
fi
mkdir nothing
path=$PATH
# shellcheck disable=SC2123 # on purpose
PATH=$PWD/nothing
emmy_run base.prm --set 'Output/Pictures=true' --set 'Output/Directory=not_drawn'
PATH=$path
check 'without gnuplot: exit code 0' [ "$status" -eq 0 ]
check 'without gnuplot: one warning on the screen' \
  has_lines 1 "$work/out" 'gnuplot is not installed'
check 'without gnuplot: one warning in run.log' \
  has_lines 1 not_drawn/run.log 'gnuplot is not installed'
check 'without gnuplot: no complaint' [ ! -s "$work/err" ]
check 'without gnuplot: scripts to draw later' [ -s not_drawn/pictures/energies.gp ]

finish
