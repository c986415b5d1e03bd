#!/bin/sh
# What emmy --check advises: each note where its cause is, and not elsewhere.
emmy=$1
source=$2
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
failed=0
n=0
last=
check() # COMMAND-LINE...: the output, once for what is the same
{
  n=$((n + 1))
  [ "$last" = "$*" ] || "$emmy" --check "$@" >"$work/out" 2>&1
  last=$*
}
has() # TEXT COMMAND-LINE...: its output has the text
{
  text=$1
  shift
  check "$@"
  grep -qF -- "$text" "$work/out" || { echo "FAILED: no <$text> for $*"; failed=1; }
}
lacks()
{
  text=$1
  shift
  check "$@"
  ! grep -qF -- "$text" "$work/out" || { echo "FAILED: <$text> for $*"; failed=1; }
}
block=$source/prm/examples/block.prm
# c = sqrt(134615/1000) = 11.6 m/s, a step of 0.5 h/c
has 'P-waves run 11.6024 m/s, 0.5 cells a step; 10 steps a period resolve waves of 5 cells' "$block"
has 'particles a cell      16' "$block"
for text in 'waves of loads' 'Is the modulus' 'Are lengths in mm' 'no solid' 'faster than' 'on faces' 'another body' 'Points per direction cost'; do
  lacks "$text" "$block"
done
for text in 'steps twice as large' 'Geometry = start' 'Shape functions = linear' 'Newton tolerance = 1e-2' 'Integrator = explicit'; do
  has "$text  " "$block"
done
lacks 'cells twice as large' "$block" # it has two across
lacks 'in their cells at the start' "$block"
has 'walls                 x-min: no body lies in their cells at the start' "$block" \
  --set "Boundary conditions/Roller=y-min, x-min"
# the box stands on faces of cells, and its boxes of GIMP reach no further; moved by a hair they feed nodes beyond it
has 'starved at the start  none' "$block"
has 'starved at the start  body block: 3 follow others, the first at (2.5, 0) m' "$block" \
  --set "Bodies/block/box/Lower corner=1.01,0" --set "Bodies/block/box/Upper corner=2.01,1"
has 'Is the modulus in MPa' "$block" --set "Materials/rubber/Density=7850" --set "Materials/rubber/Young's modulus=210000"
has 'Are lengths in mm' "$block" --set "Materials/rubber/Density=7850" --set "Materials/rubber/Young's modulus=2.1e11" \
  --set "Grid/Upper corner=40,30" --set "Bodies/block/box/Lower corner=15,0" --set "Bodies/block/box/Upper corner=25,10"
has 't/mm^3' "$block" --set "Materials/rubber/Density=7.85e-9" --set "Materials/rubber/Young's modulus=210000"
has 'Is the density in g/cm^3' "$block" --set "Materials/rubber/Density=7.85" --set "Materials/rubber/Young's modulus=2.1e11"
lacks 'Is the modulus' "$block" --set "Materials/rubber/Density=7850" --set "Materials/rubber/Young's modulus=2.1e11"
has 'half the Points per direction cost 1/4' "$block" --set "Bodies/block/Points per direction=8"
# one particle in a cell of 0.5 m stands on a face when the box is moved by 0.25 m
has '4 particles lie on faces' "$block" --set "Bodies/block/Points per direction=1" \
  --set "Bodies/block/box/Lower corner=1.25,0" --set "Bodies/block/box/Upper corner=2.25,1"
# the face of a box stands in a disc
cat >"$work/two.prm" <<'END'
set Dimension = 2
subsection Grid
  set Lower corner = 0, 0
  set Upper corner = 4, 4
  set Cells = 8, 8
end
subsection Materials
  set Names = m
  subsection m
    set Model = Hencky
    set Density = 1000
    set Young's modulus = 1e5
    set Poisson's ratio = 0.3
  end
end
subsection Bodies
  set Names = disc, box
  subsection disc
    set Shape = ball(1, 1; 0.5)
    set Material = m
    set Points per direction = 2
  end
  subsection box
    set Shape = box(1.43, 0.5; 2.43, 1.5)
    set Material = m
    set Points per direction = 2
  end
end
subsection Time
  set End time = 0.1
  set Step rule = fixed
  set Step size = 0.01
end
END
has 'another body, as of <box> into <disc>' "$work/two.prm"
lacks 'reach into another body' "$work/two.prm" --set "Bodies/box/Shape=box(1.5, 0.5; 2.5, 1.5)"
# a core and its shell share the lattice of the cells: no boxes overlap
set -- --set "Bodies/disc/Shape=ball(1, 1; 0.3)" --set "Bodies/box/Shape=difference(ball(1, 1; 0.8), ball(1, 1; 0.3))"
lacks 'reach into another body' "$work/two.prm" "$@"
has 'reach into another body' "$work/two.prm" "$@" --set "Bodies/box/Points per direction=3"
has 'with one particle in a cell' "$work/two.prm" \
  --set "Bodies/disc/Points per direction=1" --set "Bodies/box/Points per direction=1"
lacks 'with one particle in a cell' "$work/two.prm"
# tools that touch nothing as they are told to move; where each may touch, no word
examples=$source/prm/examples
for scene in bounce hammer punch ring sled; do
  lacks 'note: tool <' "$examples/$scene.prm"
done
press=$examples/press.prm
# the plate ends 0.15 m above the cube; 50 instants of 5 mm: less 2.5 mm at most
has 'tool <plate> comes no nearer than 0.1475 m' "$press" --set "Effects/Tools/plate/Reference point=0.5,1.4"
lacks 'note: tool <' "$press" --set "Effects/Tools/plate/Reference point=0.5,1.2"
# a ball beside the cube as it goes down; of one that a force pushes, nothing
sed 's/= plane/= ball/; s/subsection plane/subsection ball/; s/set Normal.*/set Radius = 0.05/' "$press" >"$work/ball.prm"
has 'tool <plate> comes no nearer than 0.0975 m' "$work/ball.prm" --set "Effects/Tools/plate/Reference point=1.15,0.7"
lacks 'note: tool <' "$work/ball.prm"
lacks 'tool <plate> comes' "$press" --set "Effects/Tools/plate/Reference point=0.5,1.4" \
  --set "Effects/Tools/plate/Pushed along=0, -1" --set "Effects/Tools/plate/Mass=1" \
  --set "Effects/Tools/plate/Force=1" --set "Effects/Tools/plate/Displacement="
# the grid ends at 1.25 m
has 'tool <plate> is outside of the grid from about t = 0.12 s on' "$press" --set "Effects/Tools/plate/Displacement=0; 2.5*t"
has 'tool <plate> is outside of the grid all the time' "$press" --set "Effects/Tools/plate/Reference point=0.5,2"
# falls by 0.2 m in the run, and starts 0.2 m above the floor: it meets one, not the other
has 'tool <floor> comes no nearer' "$examples/sled.prm" --set "Effects/Tools/floor/Reference point=0, 0.05" \
  --set "Time/End time=0.1" --set "Bodies/sled/Initial velocity=0; 0"
lacks 'tool <floor> comes no nearer' "$examples/sled.prm" --set "Effects/Tools/floor/Reference point=0, 0.05"
# c_s = sqrt(38461.5/1000) = 6.20 m/s, cells of 0.5 m, steps of 0.0215 s
amplitude='Effects/Gravity/Amplitude'
has 'gravity changes within 0.5 s: S-waves of body block are 6.2 m long, 12.4 cells; 46.4 steps a period' \
  "$block" --set "$amplitude=sin(2*pi*t)"
lacks 'cells show a wave' "$block" --set "$amplitude=sin(2*pi*t)"
has 'gravity changes within 0.1 s: S-waves of body block are 1.24 m long, 2.48 cells' \
  "$block" --set "$amplitude=cos(10*pi*t)"
has 'note: 10 cells show a wave. Take cells of 0.124 m' "$block" --set "$amplitude=cos(10*pi*t)"
has 'note: 10 steps show a period' "$block" --set "$amplitude=sin(20*pi*t)"
has 'gravity changes within 0.2 s' "$block" --set "$amplitude table=0.3: 0, 0.5: 1"
has 'gravity changes within 0.25 s' "$block" --set "$amplitude table=0: 0, 0.4: 1, 0.6: 1, 0.85: 0"
has 'gravity jumps at 0.4 s' "$block" --set "$amplitude table=0: 0, 0.4: 1, 0.4: 0"
# a wall of nodes and a plane: what they have over time
has 'the velocity of y-min changes within 0.5 s' "$block" --set "Boundary conditions/Roller=" \
  --set "Boundary conditions/Fixed=y-min" --set "Boundary conditions/Velocity of y-min=sin(2*pi*t); 0"
has 'the displacement of tool punch changes within' "$source/prm/examples/punch.prm"
lacks 'Shape functions = linear' "$source/prm/examples/punch.prm"
# steps that pass the body of 2 cells: c dt = 5 cells; h/c = 0.0431 s
has 'slowest P-waves of body <block>' "$block" --set Time/Factor=5
has 'take steps of 0.0430946 s' "$block" --set Time/Factor=5
lacks 'steps twice as large' "$block" --set Time/Factor=5
lacks 'slowest P-waves' "$block" --set Time/Factor=0.75 # 7.5 of 8 cells
# a plate 0.3 m deep in the cube, whose particles are 0.125 m apart, and the wrong way round
has 'overlaps bodies by up to 2.4 of their spacing' "$press" --set "Effects/Tools/plate/Reference point=0.5,0.7"
has 'throws them off' "$press" --set "Effects/Tools/plate/plane/Normal=0, 1"
lacks 'throws them off' "$press" --set "Effects/Tools/plate/Reference point=0.5,0.99"
# settings that the scene could take, and no others
has 'cells twice as large  ' "$block" --set Grid/Cells=80,60
lacks 'Integrator = explicit' "$block" --set 'Time/Factor=5'
lacks 'Geometry = start' "$block" --set 'Method/Geometry=start'
lacks 'steps twice as large' "$block" --set 'Time/Integrator=static' --set 'Time/Step rule=fixed' --set 'Time/Step size=1'
# their figures, in the tables of the studies: mend run/cheaper.cc with them
while IFS= read -r row; do
  n=$((n + 1))
  cat "$source/doc/accuracy-and-cost.md" "$source/doc/performance.md" | grep -qF "$row" ||
    { echo "FAILED: no table has <$row>"; failed=1; }
done <<'END'
| dt | 0.24 | 0.12 | x 1.9 | x 0.657 |
| dt | 0.00125 | 0.000625 | x 1.83 | x 0.252 |
| h | 1/8 | 1/16 | x 5.17 | x 0.379 |
| h | 1.6 | 0.8 | x 16.1 | x 0.693 | x 0.16 |
| geometry | start | middle | x 1.4 | x 0.0533 |
| geometry | start | middle | x 1.96 | x 0.688 |
| 7.3B, h = 0.5 m, 2 x 2 points | 1.25 |
| shape functions | GIMP | linear | x 0.333 | x 18.7 |
| points | 2 | 4 | x 1.18 | x 0.404 |
| Newton | 1e-2 | 1e-11 | x 1.55 |
| bar_upper_x | 0.001 | linear = 1e-2, Newton = 1e-2 | 8.82 | 1.88e-05 |
| integrator | implicit | explicit | x 0.0489 | x 7.11 |
| method | explicit | implicit | x 6.91 | x 0.0748 |
| ranks of a run | 1 | 2 | x 0.679 |
END
echo "$n checks"
exit $failed
