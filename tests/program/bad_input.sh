#!/bin/sh
# What emmy cannot use it refuses in words: where, what, and how to mend it;
# with a non-zero exit code, once however many ranks there are, and without
# leaving half a run behind. A run that stops on the way keeps its results.
#
# Usage: bad_input.sh EMMY SOURCE_ROOT MPI_LAUNCHER
set -u

[ $# -eq 3 ] || { echo "usage: bad_input.sh EMMY SOURCE_ROOT MPI_LAUNCHER" >&2; exit 2; }
# shellcheck source=tests/program/checks.sh
. "$2/tests/program/checks.sh"
emmy=$(absolute "$1")
launcher=$3
cd "$work" || exit 2
mkdir run && cd run || exit 2 # output of emmy goes beside it
tiny_scene >base.prm

# expect_error NAME WORDS: one error message, which holds all WORDS, a list
# separated by |
expect_error()
{
  check "$1: one error message" has_lines 1 "$work/err" '^emmy: error: [^ ]'
  wanted=$2
  while [ -n "$wanted" ]; do
    check "$1: says <${wanted%%|*}>" says "$work/err" "${wanted%%|*}"
    case $wanted in
      *'|'*) wanted=${wanted#*|} ;;
      *) wanted= ;;
    esac
  done
}

# refused NAME WORDS ARGUMENTS...: emmy says WORDS, fails, and leaves nothing
refused()
{
  name=$1 words=$2
  shift 2
  before=$(state .)
  emmy_run "$@"
  check "$name: exit code 1" [ "$status" -eq 1 ]
  check "$name: nothing else is printed" [ ! -s "$work/out" ]
  expect_error "$name" "$words"
  check "$name: nothing is written" [ "$(state .)" = "$before" ]
}

# refused_set NAME WORDS ENTRY=VALUE: the same, of base.prm with another value
refused_set()
{
  refused "$1" "$2" base.prm --set "$3"
}

# without ENTRY: base.prm without a line, as less.prm
without()
{
  grep -v "set $1 " base.prm >less.prm
}


echo "Names"
cat >typo.prm <<'END'
include base.prm
subsection Grdi
  set Cells = 1, 1
end
END
refused 'unknown section' \
  'typo.prm, line 2|unknown section <Grdi>|did you mean <Grid>?' typo.prm
cat >typo.prm <<'END'
include base.prm
subsection Materials
  subsection rubber
    set Densty = 1
  end
end
END
refused 'unknown entry' \
  'typo.prm, line 4|<Materials/rubber/Densty>|did you mean <Density>?' typo.prm
cat >typo.prm <<'END'
include base.prm
set Titel = a
subsection Tmie
end
subsection Time
  set Endtime = 1
end
END
refused 'several unknown names' \
  'line 2: unknown parameter <Titel>|line 3: unknown section <Tmie>|line 6: unknown parameter <Time/Endtime>|did you mean <Title>?|did you mean <Time>?|did you mean <End time>?|--set: unknown parameter <Output/Frame>|did you mean <Frames>?' \
  typo.prm --set 'Output/Frame=1'
refused 'several unusable values' \
  '<Time/End time> is <soon>|must be a number|<Grid/Cells> is <4>|must be a list of 2 items' \
  base.prm --set 'Time/End time=soon' --set 'Grid/Cells=4'
cat >typo.prm <<'END'
include base.prm
subsection Bodies
  subsection another
    set Shape = box
  end
end
END
refused 'a body that is not listed' \
  'line 3|unknown section <Bodies/another>|must stand in <Bodies/Names>' typo.prm
rm typo.prm
refused_set 'unknown material of a body' \
  '<Bodies/block/Material> is <ruber>|did you mean <rubber>?|Materials/Names: rubber' \
  'Bodies/block/Material=ruber'
refused_set 'unknown shape' \
  '<Bodies/block/Shape> is <bax>|did you mean <box>?|Known are: box, ball, mesh, expression' \
  'Bodies/block/Shape=bax'
refused_set 'unknown model' \
  '<Materials/rubber/Model> is <Hooke>|Known are: Hencky' \
  'Materials/rubber/Model=Hooke'
refused_set 'unknown effect' \
  '<Effects/Names> is <gravitation>|Known are: gravity, point load, surface loads, mass damping, viscous sides, contact, tools, ghost stabilisation' 'Effects/Names=gravitation'
refused_set 'unknown side of the grid' \
  '<Boundary conditions/Fixed> is <z-min>|no such side|x-min, x-max, y-min, y-max' \
  'Boundary conditions/Fixed=x-min, z-min'

echo "Constants and measures"
without 'Density'
refused 'missing density' '<Materials/rubber/Density>|required|kg/m^3' less.prm
without "Young's modulus"
refused "missing Young's modulus" \
  "<Materials/rubber/Young's modulus>|missing|Set Young's modulus (Pa)" less.prm
for ratio in 0.5 -1; do
  refused_set "Poisson's ratio $ratio" \
    "<Materials/rubber/Poisson's ratio> is <$ratio>|between -1 and 0.5, both excluded|use 0.49" \
    "Materials/rubber/Poisson's ratio=$ratio"
done
sed -e 's/Hencky/von Mises/' -e '/Poisson/a set Yield stress = 10' base.prm >plastic.prm
refused 'missing yield stress' '<Materials/rubber/Yield stress> is <0>|required|positive (Pa)' \
  base.prm --set 'Materials/rubber/Model=von Mises'
for stress in 0 -2; do
  refused "yield stress $stress" \
    "<Materials/rubber/Yield stress> is <$stress>|must be positive (Pa)|use Model = Hencky" \
    plastic.prm --set "Materials/rubber/Yield stress=$stress"
done
refused 'negative hardening' \
  '<Materials/rubber/Hardening modulus> is <-1>|must not be negative (Pa)|Use 0' \
  plastic.prm --set 'Materials/rubber/Hardening modulus=-1'
refused 'deviatoric with hardening' \
  '<Materials/rubber/Hardening modulus> is <1>|must be 0 with Yield measure = deviatoric|use Yield measure = uniaxial' \
  plastic.prm --set 'Materials/rubber/Hardening modulus=1' \
  --set 'Materials/rubber/Yield measure=deviatoric'
refused 'unknown yield measure' \
  '<Materials/rubber/Yield measure> is <radial>|one of uniaxial, deviatoric' \
  plastic.prm --set 'Materials/rubber/Yield measure=radial'
refused 'unknown stress rule' \
  '<Method/Stress rule> is <midpoint>|one of conserving, mid-point, trapezoidal, end-point' \
  base.prm --set 'Method/Stress rule=midpoint'
rm plastic.prm
without 'Upper corner'
refused 'missing Upper corner' \
  '<Grid/Upper corner>|must lie above the lower corner|in m' less.prm
refused_set 'zero cells' '<Grid/Cells> is <0, 4>|at least 1' 'Grid/Cells=0, 4'
without 'Points per direction'
refused 'missing Points per direction' \
  '<Bodies/block/Points per direction>|required' less.prm
sed 's/set Dimension/set dimension/' base.prm >less.prm
refused 'Dimension in small letters' \
  '<Dimension> is <>|Did you mean <Dimension>? The file has <dimension>' less.prm
rm less.prm

echo "Bodies"
for n in 27104 417301; do
  refused_set "$n points per direction" \
    'about|particles,|of them in body <block>: the|lower its Points per direction' \
    "Bodies/block/Points per direction=$n"
done
refused 'body without particles' \
  'body <block> holds no particle|raise its Points per direction' \
  base.prm --set 'Bodies/block/Particle layout=cells' --set 'Bodies/block/box/Upper corner=1.01, 2'
refused_set 'body outside the grid' \
  'body <block> spans x = 1 ... 9 m|not inside the grid, 0 ... 4 m|enlarge the grid' \
  'Bodies/block/box/Upper corner=9, 2'
refused_set 'body cut by a side that is none' \
  '<Bodies/block/Cut by> is <left>|no such side|x-min, x-max' 'Bodies/block/Cut by=left'
refused 'body that is cut at one side and reaches beyond another' 'body <block> spans x' \
  base.prm --set 'Bodies/block/Cut by=y-max' --set 'Bodies/block/box/Upper corner=9, 9'
cat >overlap.prm <<'END'
include base.prm
subsection Bodies
  set Names = block, disc
  subsection disc
    set Shape                = ball
    set Material             = rubber
    set Points per direction = 4
    subsection ball
      set Center = 2, 2
      set Radius = 0.5
    end
  end
end
END
refused 'overlapping bodies' \
  'bodies <block> and <disc> overlap, e.g. at (|move or shrink' overlap.prm
rm overlap.prm
refused_set 'malformed velocity' \
  '<Bodies/block/Initial velocity> is <1*; 0>|Unexpected end of expression|Write 2 components separated by , or ;' \
  'Bodies/block/Initial velocity=1*; 0'
refused_set 'velocity with one component' \
  '<Bodies/block/Initial velocity> is <1>|Write 2 components separated by , or ;' \
  'Bodies/block/Initial velocity=1'
refused_set 'velocity that is no number' \
  'initial velocity of body <block>|nan m/s at (|must be finite' \
  'Bodies/block/Initial velocity=sqrt(-1); 0'
sed -e 's/= box/= expression/' -e 's/subsection box/subsection expression/' \
  -e '/set Lower corner = 1, 1/d' -e 's/Upper corner = 2, 2/Expression = 1 - r^2/' \
  base.prm >formula.prm
refused 'malformed shape' \
  '<Bodies/block/expression/Expression> is <1 - r^2>|Unexpected token "r|Write a formula in x,y' \
  formula.prm
refused 'formula with one corner' \
  '<Bodies/block/expression/Upper corner>|required: 2 coordinates in m' \
  formula.prm --set 'Bodies/block/expression/Expression=1' \
  --set 'Bodies/block/expression/Lower corner=1, 1'
rm formula.prm

echo "Time, solver and output"
refused_set 'negative end time' '<Time/End time> is <-1>|must be positive (s)' \
  'Time/End time=-1'
for factor in -1 0; do
  refused "factor $factor" "<Time/Factor> is <$factor>|must be positive" \
    base.prm --set 'Time/Step rule=wave' --set "Time/Factor=$factor"
done
without 'Step size'
refused 'missing step size' '<Time/Step size>|required|with Step rule = fixed' less.prm
rm less.prm
refused_set 'unusable tolerance' \
  '<Solver/Newton tolerance> is <1>|between 0 and 1, both excluded' \
  'Solver/Newton tolerance=1'
refused_set 'negative picture time' \
  '<Output/Picture times> is <-1>|must not be negative' 'Output/Picture times=0, -1'
refused_set 'no output folder' '<Output/Directory> is <>|must name a folder' \
  'Output/Directory='
refused_set 'output folder below a file' \
  'the folder <base.prm/results> cannot be created|check' \
  'Output/Directory=base.prm/results'
if [ -d /proc/self ]; then # nobody may write there
  refused_set 'output folder in a place that cannot be written to' \
    'the folder </proc/emmy> cannot be created|check' 'Output/Directory=/proc/emmy'
fi
if [ "$(id -u)" -ne 0 ]; then # root may write anywhere
  mkdir closed && chmod a-w closed
  refused_set 'output folder without permission to write' \
    'no file can be written in the folder <closed>|permissions' 'Output/Directory=closed'
  rmdir closed
fi

echo "Method"
for epsilon in -0.1 1.5; do
  refused_set "lumping $epsilon" \
    "<Method/Lumping> is <$epsilon>|between 0 (consistent) and 1 (lumped)" \
    "Method/Lumping=$epsilon"
done
refused_set 'blend without its fraction' \
  '<Method/FLIP fraction> is <-1>|Mapping = blend requires it, between 0 (PIC) and 1 (FLIP)' \
  'Method/Mapping=blend'
refused 'a fraction above one' '<Method/FLIP fraction> is <1.1>|between 0 (PIC) and 1' \
  base.prm --set 'Method/Mapping=blend' --set 'Method/FLIP fraction=1.1'
for mapping in FLIP PIC; do
  refused "$mapping with a fraction" \
    "<Method/FLIP fraction> is <0.9>|Mapping = $mapping contradicts it|set Mapping = blend" \
    base.prm --set "Method/Mapping=$mapping" --set 'Method/FLIP fraction=0.9'
done
for walls in unconstrained inelastic; do
  refused "PIC with $walls walls" \
    "<Method/Wall mapping> is <$walls>|Mapping = PIC contradicts it|Use constrained" \
    base.prm --set 'Method/Mapping=PIC' --set "Method/Wall mapping=$walls"
done
refused_set 'unknown shape functions' \
  '<Method/Shape functions> is <quadratic>|one of linear, GIMP' \
  'Method/Shape functions=quadratic'
refused_set 'unknown stress rule' '<Method/Stress rule> is <best>|one of conserving' \
  'Method/Stress rule=best'

echo "Ghost stabilisation"
for penalty in Mass Stiffness; do
  refused "negative $penalty penalty" \
    "<Effects/Ghost stabilisation/$penalty penalty> is <-1>|must not be negative" \
    base.prm --set 'Effects/Names=ghost stabilisation' \
    --set "Effects/Ghost stabilisation/$penalty penalty=-1"
done
refused 'no penalty' '<Effects/Ghost stabilisation/Mass penalty> is <0>|both penalties are zero' \
  base.prm --set 'Effects/Names=ghost stabilisation' \
  --set 'Effects/Ghost stabilisation/Mass penalty=0' \
  --set 'Effects/Ghost stabilisation/Stiffness penalty=0'

echo "Starved nodes"
refused 'a threshold of 1' \
  '<Method/Starved threshold> is <1>|must lie between 0 and 1|0 chooses' \
  base.prm --set 'Method/Starved nodes=follow' --set 'Method/Starved threshold=1'
for mapping in unconstrained inelastic; do
  refused "followers with $mapping walls" \
    "<Method/Wall mapping> is <$mapping>|it must be <constrained>|Starved nodes = free" \
    base.prm --set 'Method/Starved nodes=follow' --set 'Boundary conditions/Fixed=y-min' \
    --set "Method/Wall mapping=$mapping"
done
refused 'the effect that it was' \
  '<Effects/Names> is <gravity, aggregation>|no effect any more|Method/Starved nodes = follow|Method/Starved threshold' \
  base.prm --set 'Effects/Names=gravity, aggregation'
refused 'its section' \
  'no effect any more|remove <aggregation> here and the section Effects/Aggregation' \
  base.prm --set 'Effects/Aggregation/Mass threshold=0.2'

echo "Walls"
refused_set 'velocity of a free side' \
  '<Boundary conditions/Velocity of y-min> is <t>|this side is free|<Fixed> or <Roller>' \
  'Boundary conditions/Velocity of y-min=t'
refused 'velocity with one component of a fixed side' \
  '<Boundary conditions/Velocity of y-min> is <t>|Write 2 components separated by , or ;' \
  base.prm --set 'Boundary conditions/Fixed=y-min' \
  --set 'Boundary conditions/Velocity of y-min=t'
refused 'malformed velocity of a roller' \
  '<Boundary conditions/Velocity of y-min> is <0; x>|Write one formula in t' \
  base.prm --set 'Boundary conditions/Roller=y-min' \
  --set 'Boundary conditions/Velocity of y-min=0; x'
emmy_run base.prm --set 'Boundary conditions/Fixed=y-min' \
  --set 'Boundary conditions/Velocity of y-min=1/(t - 0.25); 0'
check 'infinite velocity of a wall: exit code 1' [ "$status" -eq 1 ]
expect_error 'infinite velocity of a wall' \
  'Boundary conditions: <Velocity of y-min> is inf m/s at t = 0.25 s|correct the formula'
check 'infinite velocity of a wall: the ledger has the two accepted rows' \
  has_lines 4 results/ledger.csv
rm -rf results

# a side acts where the grid ends, not where the wall would be
for velocity in 0.05 -0.05 'if(t > 0.5, 0.05, 0)'; do
  refused "a roller that moves along its normal by $velocity" \
    "<Boundary conditions/Velocity of y-min> is <$velocity>|along its normal by|cells, and passes 1 % of a cell at t = |act where the grid ends|name <tools> in Effects/Names" \
    base.prm --set 'Boundary conditions/Roller=y-min' \
    --set "Boundary conditions/Velocity of y-min=$velocity"
done
refused 'a fixed side that moves along its normal' \
  '<Boundary conditions/Velocity of y-min> is <0; 0.05>|would move along its normal by 0.05 m, 0.05 cells' \
  base.prm --set 'Boundary conditions/Fixed=y-min' \
  --set 'Boundary conditions/Velocity of y-min=0; 0.05'
refused 'a side that comes back' 'along its normal by 0.0159' \
  base.prm --set 'Boundary conditions/Roller=y-min' \
  --set 'Boundary conditions/Velocity of y-min=0.05*sin(2*pi*t)'
emmy_run base.prm --set 'Boundary conditions/Fixed=y-min' \
  --set 'Boundary conditions/Velocity of y-min=2; 0.03*sin(2*pi*t)'
check 'a side that moves along itself, and by 0.0095 m else: runs' [ "$status" -eq 0 ]
rm -rf results
# the number of steps is limited: nobody knows beforehand
emmy_run base.prm --set 'Boundary conditions/Roller=y-min' --set 'Time/Maximum steps=100' \
  --set 'Time/Step rule=wave' --set 'Time/Factor=1' \
  --set 'Boundary conditions/Velocity of y-min=if(t > 0.3, 0.05, 0)'
check 'a side that moves too far on the way: exit code 1' [ "$status" -eq 1 ]
expect_error 'a side that moves too far on the way' \
  'Step |the side y-min would have moved by|along its normal|last accepted state was kept'
check 'a side that moves too far on the way: the ledger has the steps before' \
  is "$(last results time) > 0.3 && $(last results time) < 0.51"
rm -rf results

echo "Small cuts"
# a single particle: its mass has rank one, so Newton gets one iteration
falling='Effects/Names=gravity'
alone='Bodies/block/Points per direction=1'
emmy_run base.prm --set "$alone" --set "$falling" --set 'Effects/Gravity/Acceleration=0, -1' \
  --set 'Solver/Maximum iterations=1' --set 'Time/Maximum halvings=0'
check 'a step that fails at a small cut: exit code 1' [ "$status" -eq 1 ]
expect_error 'a step that fails at a small cut' \
  'Step 1 from t = 0 s|the scaled Jacobian has the condition number|singular to round-off|weakest at node (|m of the active cell around (1.5, 1.5); 1 particle reaches it: id 0 at (1.5, 1.5) with S = 0.25|set Method/Starved nodes = follow|Method/Lumping above 0|more Points per direction'
check 'a step that fails at a small cut: no talk of thresholds' has_lines 0 "$work/err" threshold
rm -rf results
emmy_run base.prm --set "$alone" --set 'Method/Starved nodes=follow' --set 'Effects/Names=gravity, ghost stabilisation' \
  --set 'Effects/Gravity/Acceleration=0, -1' --set 'Method/Lumping=1e-16' \
  --set 'Effects/Ghost stabilisation/Mass penalty=1e-16' --set 'Effects/Ghost stabilisation/Stiffness penalty=0' \
  --set 'Solver/Maximum iterations=1' --set 'Time/Maximum halvings=0'
expect_error 'what is there already is not advised again' \
  'singular to round-off|Against small cuts, raise Method/Starved threshold, or raise Effects/Ghost stabilisation/Mass penalty. Use more'
rm -rf results
emmy_run base.prm --set 'Bodies/block/Initial velocity=x; 0' \
  --set 'Solver/Maximum iterations=1' --set 'Time/Maximum halvings=0'
check 'a step that fails elsewhere: exit code 1' [ "$status" -eq 1 ]
expect_error 'a step that fails elsewhere' \
  'the scaled Jacobian has the condition number|so no small cut is to blame|larger Solver/Maximum iterations'
check 'a step that fails elsewhere: no talk of ghosts' has_lines 0 "$work/err" ghost
rm -rf results

echo "Domains of GIMP"
# A turn by 90 degrees: F_ii = 0.
turning='Bodies/block/Initial velocity=-6*(y - 1.5); 6*(x - 1.5)'
emmy_run base.prm --set 'Method/Shape functions=GIMP' --set 'Method/Domain update=diagF' \
  --set "$turning" --set 'Time/Step size=0.01'
check 'vanishing domain: exit code 1' [ "$status" -eq 1 ]
expect_error 'vanishing domain' \
  'the half-length of particle|would become|above 1e-6 of the cell size 1 m|Domain update (stretch does not vanish'
check 'vanishing domain: run.log tells the reason' \
  matches results/run.log 'stopped: Step [0-9]+ .* the half-length of particle'
check 'vanishing domain: the last accepted step is there' \
  matches results/run.log '^steps [1-9][0-9]*, t = 0.2'
rm -rf results
emmy_run base.prm --set 'Method/Shape functions=GIMP' --set "$turning" \
  --set 'Time/Step size=0.01' --set 'Time/End time=0.3'
check 'turning with stretch: runs' [ "$status" -eq 0 ]
rm -rf results
echo "Command line"
refused 'no file' 'no parameter file|name one' --check
refused 'two files' 'two parameter files, <base.prm> and <b.prm>|give one' base.prm b.prm
refused 'missing file' 'cannot read the file <none.prm>|check the name' none.prm
refused 'unknown option' 'unknown option <--frob>|emmy --help' base.prm --frob
refused 'misspelt option' 'unknown option <--chek>|did you mean <--check>' base.prm --chek
refused 'short option' 'unknown option <-q>|emmy --help' -q base.prm
refused 'an option with a value' '--check with a value|--check alone' --check=yes base.prm
refused 'unknown topic' 'no help on <efects>|did you mean <Effects>' --help efects
refused 'completion of another shell' 'completion for <csh>|completion bash' completion csh
refused '--set=' '--set has no value|Section/Name=value' base.prm --set=
refused '--set without a value' '--set has no value|Section/Name=value' base.prm --set
for assignment in 'End time' 'Time/=1'; do
  refused "malformed --set <$assignment>" \
    "--set: cannot understand <$assignment>|Section/Subsection/Name=value" \
    base.prm --set "$assignment"
done

echo "Amplitudes"
# refused_amplitude NAME WORDS ENTRY=VALUE...: of gravity
refused_amplitude()
{
  name=$1 words=$2
  shift 2
  for entry; do
    shift
    set -- "$@" --set "Effects/Gravity/$entry"
  done
  refused "$name" "$words" base.prm --set 'Effects/Names=gravity' \
    --set 'Effects/Gravity/Acceleration=0, -9.81' "$@"
}
refused_amplitude 'malformed amplitude' \
  '<Effects/Gravity/Amplitude> is <2*(t>: it cannot be read (|Missing parenthesis|Write a formula in t' \
  'Amplitude=2*(t'
refused_amplitude 'amplitude in space' \
  '<Effects/Gravity/Amplitude> is <x>|Unexpected token "x"|Write a formula in t' 'Amplitude=x'
refused_amplitude 'two amplitudes' \
  '<Effects/Gravity/Amplitude> is <t>: <Amplitude table> is given too, <0: 1>|Remove one' \
  'Amplitude=t' 'Amplitude table=0: 1'
for item in 'one' '1' '1: 2: 3' '1: nan' '1: 5x'; do
  refused_amplitude "malformed amplitude table <$item>" \
    "<Effects/Gravity/Amplitude table> is <0: 1, $item>|<$item> is not a pair|Write pairs <time: value>" \
    "Amplitude table=0: 1, $item"
done
refused_amplitude 'amplitude table out of order' \
  '<Effects/Gravity/Amplitude table> is <0: 0, 2: 1, 1.5: 0>|time 1.5 s stands after 2 s|do not decrease' \
  'Amplitude table=0: 0, 2: 1, 1.5: 0'
refused_amplitude 'amplitude table with a time thrice' \
  '<Effects/Gravity/Amplitude table>|time 1 s stands there more than twice' \
  'Amplitude table=1: 0, 1: 1, 1: 2'
refused_amplitude 'unknown sampling' \
  '<Effects/Gravity/Sampling> is <start>|one of mid, end' 'Sampling=start'

echo "Manufactured solution"
# refused_motion NAME WORDS ASSIGNMENT...: a block at rest that shall vibrate
refused_motion()
{
  name=$1 words=$2
  shift 2
  exact='Effects/Manufactured solution'
  refused "$name" "$words" base.prm --set 'Effects/Names=manufactured solution' \
    --set 'Bodies/block/Initial velocity=0; 0' --set "$exact/Period=1" \
    --set "$exact/vibration/Lower corner=1, 1" --set "$exact/vibration/Upper corner=2, 2" \
    --set "$exact/vibration/Amplitude=0.1, 0.1" "$@"
}
exact='Effects/Manufactured solution'
refused_motion 'motion without a period' \
  "<$exact/Period> is <0>|it is required and must be positive" --set "$exact/Period=0"
refused_motion 'motion without an amplitude' \
  "<$exact/vibration/Amplitude> is <>|it is required: 2 numbers in m" \
  --set "$exact/vibration/Amplitude="
refused_motion 'motion that turns the box inside out' \
  "<$exact/vibration/Amplitude> is <0.1, -0.4>|component y must be below 0.31831 m|no volume left" \
  --set "$exact/vibration/Amplitude=0.1, -0.4"
refused_motion 'box without size' \
  "<$exact/vibration/Upper corner> is <2, 1>|must lie above the lower corner" \
  --set "$exact/vibration/Upper corner=2, 1"
refused_motion 'motion of another body' \
  "$exact: a particle at (|outside of the body that the motion is of, the box from (1, 1) to (1.5, 2) m|let the shapes" \
  --set "$exact/vibration/Upper corner=1.5, 2"
refused_motion 'motion of a body that moves' \
  "$exact: a particle at (|has an initial velocity|remove the bodies' <Initial velocity>" \
  --set 'Bodies/block/Initial velocity=1; 0'
refused_motion 'ring without an inner radius' \
  "<$exact/vortex/Inner radius> is <0>|must be positive" --set "$exact/Motion=vortex" \
  --set "$exact/vortex/Center=1, 1"
refused_motion 'motion of a plastic body' \
  '<Effects/Names> is <manufactured solution>|bodies of an elastic material' \
  --set 'Materials/rubber/Model=von Mises' --set 'Materials/rubber/Yield stress=1'


echo "Point load"
# refused_load NAME WORDS ENTRY=VALUE...
refused_load()
{
  name=$1 words=$2
  shift 2
  for entry; do
    shift
    set -- "$@" --set "Effects/Point load/$entry"
  done
  refused "$name" "$words" base.prm --set 'Effects/Names=point load' "$@"
}
refused_load 'load without force' \
  '<Effects/Point load/Force> is <>|required: 2 components in N, separated by , or ;|0; -500e3' \
  'Region=1'
refused_load 'load with one component' \
  '<Effects/Point load/Force> is <1.5>|required: 2 components in N' 'Force=1.5' 'Region=1'
refused_load 'load with three components' \
  '<Effects/Point load/Force> is <1; 2; 3>|a list of 0 to 2 items separated by <,> or <;>, each a number' \
  'Force=1; 2; 3' 'Region=1'
refused_load 'load without particles' \
  '<Effects/Point load/Points nearest to> is <>|Give positions|or <Region>' 'Force=0; 1'
refused_load 'load with both choices' \
  '<Effects/Point load/Region> is <x>: <Points nearest to> is given too|Remove one' \
  'Force=0; 1' 'Region=x' 'Points nearest to=1, 1'
refused_load 'position with one coordinate' \
  '<Effects/Point load/Points nearest to> is <1, 1; 2>|separated by <;>, each a list of 2 items separated by <,>' \
  'Force=0; 1' 'Points nearest to=1, 1; 2'
refused_load 'load on no particle' \
  '<Effects/Point load/Region> is <x - 3>|no particle is inside|positive at the particles' \
  'Force=0; 1' 'Region=x - 3'
refused_load 'load outside the grid' \
  '<Effects/Point load/Points nearest to> is <9, -9>|outside the grid|in m' \
  'Force=0; 1' 'Points nearest to=1, 1; 9, -9'
refused_load 'malformed region' \
  '<Effects/Point load/Region> is <x ->|cannot be read|Write a formula in x,y' \
  'Force=0; 1' 'Region=x -'
# In steps of 1/8 s the middle of the third is at 0.3125 s.
pole='Effects/Point load/Amplitude=1/(t - 0.3125)'
emmy_run base.prm --set 'Effects/Names=point load' --set 'Effects/Point load/Force=1; 0' \
  --set 'Effects/Point load/Region=x - 1.5' --set "$pole"
check 'infinite amplitude: exit code 1' [ "$status" -eq 1 ]
expect_error 'infinite amplitude' \
  'Effects/Point load: Amplitude <1/(t - 0.3125)> is inf at t = 0.3125 s|must be finite'
check 'infinite amplitude: the ledger has the two accepted rows' has_lines 4 results/ledger.csv
check 'infinite amplitude: run.log tells on what the load acts' \
  has_lines 1 results/run.log 'point load on 8 particles$'
check 'infinite amplitude: run.log tells the reason' \
  matches results/run.log 'stopped: Effects/Point load: .* is inf at t = 0.3125 s'
rm -rf results

echo "Gravity"
refused_set 'gravity without acceleration' \
  '<Effects/Gravity/Acceleration>|required: 2 components in m/s^2|0, -9.81' \
  'Effects/Names=gravity'
emmy_run base.prm --set 'Effects/Gravity/Acceleration=0, -9.81' --set 'Time/Maximum steps=1'
check 'gravity that is not named: runs' [ "$status" -eq 0 ]
check 'gravity that is not named: one note on the screen' \
  has_lines 1 "$work/out" 'note: section Effects/Gravity is not used'
check 'gravity that is not named: one note in run.log' \
  has_lines 1 results/run.log 'note: section Effects/Gravity is not used'

echo "A folder that holds a run"
echo 'mine' >results/notes.txt
refused 'a folder that holds a run' \
  'the folder <results> already holds a run|--overwrite' base.prm
refused 'a wrong file, though it may overwrite' '<Time/End time> is <-1>' \
  base.prm --overwrite --set 'Time/End time=-1'
emmy_run base.prm --overwrite --set 'Time/Maximum steps=2' --set 'Output/Frames=0'
check '--overwrite: runs' [ "$status" -eq 0 ]
check '--overwrite: the new ledger is there' has_lines 4 results/ledger.csv
check '--overwrite: files of the old run are gone' [ ! -e results/particles.pvd ]
check '--overwrite: other files stay' [ "$(cat results/notes.txt)" = mine ]
rm -rf results

echo "A particle that leaves the grid"
# The foremost particles fly from x = 2 - 1/12 m at 1 m/s; the grid ends at 2.5 m.
emmy_run base.prm --set 'Grid/Upper corner=2.5, 4' --set 'Output/Frames=1' \
  --set 'Time/Maximum halvings=0'
check 'leaving: exit code 1' [ "$status" -eq 1 ]
expect_error 'leaving' \
  'Step 5 from t = 0.5 s|would leave the grid, to (2.541|Enlarge the grid|fix that side'
check 'leaving: names the particle and its position' \
  matches "$work/err" 'particle [0-9]+ at \(2\.416[0-9]*, [0-9.]+\) m'
check 'leaving: the ledger has the four accepted rows' has_lines 6 results/ledger.csv
check 'leaving: the last row is the last accepted step' \
  [ "$(tail -n 1 results/ledger.csv | cut -d , -f 1,2)" = '4,0.5' ]
check 'leaving: run.log tells the reason' \
  matches results/run.log 'stopped: Step 5 .* particle [0-9]+ at .* would leave the grid'
check 'leaving: the particles of the last accepted step are there' \
  says results/particles.pvd 'timestep="0.5"'
check 'leaving: no grid of the failed step' [ ! -e results/grid.pvd ]
check 'leaving: timing.json is there' [ -s results/timing.json ]
rm -rf results
# Steps are halved before the run stops: until a quarter of a thousandth is left.
emmy_run base.prm --set 'Grid/Upper corner=2.5, 4'
check 'leaving with smaller steps: exit code 1' [ "$status" -eq 1 ]
expect_error 'leaving with smaller steps' \
  'Step 9 from t = 0.583|would leave the grid|with the step halved 8 times to 0.000488281 s'
check 'leaving with smaller steps: the ledger has the eight accepted rows' \
  has_lines 10 results/ledger.csv
check 'leaving with smaller steps: as far as it goes' \
  is "$(last results time) > 0.5829 && $(last results time) < 0.58334"
check 'leaving with smaller steps: a short line on the screen' \
  matches "$work/out" '^Step 5 from t = 0.5 s: halved to 0.0625 s$'
check 'leaving with smaller steps: why, in run.log' \
  matches results/run.log 'Step 5 from t = 0.5 s: particle .* would leave the grid.*; halved to 0.0625 s'
rm -rf results

echo "Newton"
emmy_run base.prm --set 'Bodies/block/Initial velocity=x; 0' --set 'Time/Step size=1e3' \
  --set 'Time/Shorten last step=false' \
  --set 'Solver/Maximum iterations=1' --set 'Time/Maximum halvings=2'
check 'first step fails: exit code 1' [ "$status" -eq 1 ]
expect_error 'first step fails' \
  'Step 1 from t = 0 s|Newton does not converge|halved 2 times to 250 s|Step size'
check 'first step fails: run.log says the same' \
  matches results/run.log 'stopped: Step 1 .*halved 2 times to 250 s'
check 'first step fails: the ledger has the initial row alone' has_lines 2 results/ledger.csv
rm -rf results
# Free flight needs no iteration, a wall does: one is not enough.
emmy_run base.prm --set 'Grid/Upper corner=3, 4' --set 'Grid/Cells=3, 4' \
  --set 'Boundary conditions/Fixed=x-max' \
  --set 'Solver/Maximum iterations=1' --set 'Time/Maximum halvings=2'
check 'a later step fails: exit code 1' [ "$status" -eq 1 ]
expect_error 'a later step fails' \
  'Step 3 from t = 0.25 s|not converged in 1 iterations|halved 2 times to 0.03125 s|was kept'
check 'a later step fails: the ledger has two accepted rows' has_lines 4 results/ledger.csv
check 'a later step fails: the last row is the last accepted step' \
  [ "$(tail -n 1 results/ledger.csv | cut -d , -f 1,2)" = '2,0.25' ]
check 'a later step fails: run.log says that the step was halved' \
  matches results/run.log 'stopped: Step 3 .*halved 2 times to 0.03125 s'
rm -rf results
# A body that shrinks to nothing within the step, and within half of it.
emmy_run base.prm --set 'Bodies/block/Initial velocity=-8*(x-1.5); 0' \
  --set 'Time/Step size=1' --set 'Time/Maximum steps=1'
check 'a halved step: runs' [ "$status" -eq 0 ]
check 'a halved step: run.log tells both halvings' \
  has_lines 2 results/run.log 'Step 1 .*; halved to 0.2?5 s'
check 'a halved step: the ledger has the smaller step' \
  [ "$(tail -n 1 results/ledger.csv | cut -d , -f 1-3)" = '1,0.25,0.25' ]
rm -rf results

echo "Two ranks"
# refused_by_two NAME WORDS ARGUMENTS...: as refused(); the launcher has its say
refused_by_two()
{
  name="$1, two ranks" words=$2
  shift 2
  before=$(state .)
  run_on_two_ranks "$@"
  check "$name: fails" [ "$status" -ne 0 ]
  check "$name: does not hang" [ "$status" -ne 124 ]
  expect_error "$name" "$words"
  check "$name: says nothing twice" not matches "$work/err" '^Message:|unexpected error'
  check "$name: nothing is written" [ "$(state .)" = "$before" ]
}

# a column across both ranks
across='Bodies/block/box/Upper corner=2, 3'
refused_by_two 'unknown entry' '<Time/Endtime>|did you mean <End time>?' \
  base.prm --set 'Time/Endtime=2'
refused_by_two 'malformed velocity' '<Bodies/block/Initial velocity>|Write 2 components' \
  base.prm --set 'Bodies/block/Initial velocity=foo; 0'
refused_by_two 'body outside the grid' 'body <block> spans x' \
  base.prm --set 'Bodies/block/box/Upper corner=9, 2'
run_on_two_ranks base.prm --set "$across" --set 'Grid/Upper corner=2.5, 4' \
  --set 'Time/Maximum halvings=0'
check 'leaving, two ranks: fails' [ "$status" -ne 0 ]
check 'leaving, two ranks: does not hang' [ "$status" -ne 124 ]
expect_error 'leaving, two ranks' 'Step 5 from t = 0.5 s|would leave the grid, to (2.541'
check 'leaving, two ranks: the ledger has the four accepted rows' has_lines 6 results/ledger.csv
check 'leaving, two ranks: run.log tells the reason once' \
  has_lines 1 results/run.log 'stopped: Step 5 .* would leave the grid'
rm -rf results
refused_by_two 'load on no particle' '<Effects/Point load/Region> is <x - 3>|no particle' \
  base.prm --set "$across" --set 'Effects/Names=point load' \
  --set 'Effects/Point load/Force=1; 0' --set 'Effects/Point load/Region=x - 3'
refused_by_two 'malformed amplitude table' '<Effects/Point load/Amplitude table> is <0>' \
  base.prm --set "$across" --set 'Effects/Names=point load' \
  --set 'Effects/Point load/Force=1; 0' --set 'Effects/Point load/Region=1' \
  --set 'Effects/Point load/Amplitude table=0'
run_on_two_ranks base.prm --set "$across" --set 'Effects/Names=point load' \
  --set 'Effects/Point load/Force=1; 0' --set 'Effects/Point load/Region=1' --set "$pole"
check 'infinite amplitude, two ranks: fails' [ "$status" -ne 0 ]
check 'infinite amplitude, two ranks: does not hang' [ "$status" -ne 124 ]
expect_error 'infinite amplitude, two ranks' 'Effects/Point load: Amplitude|is inf at t = 0.3125 s'
check 'infinite amplitude, two ranks: the ledger has the two accepted rows' \
  has_lines 4 results/ledger.csv
rm -rf results
# All sixteen particles are in one cell.
run_on_two_ranks base.prm --set 'Time/Maximum steps=1'
check 'a rank without particles: runs' [ "$status" -eq 0 ]

finish
