#!/bin/sh
# What emmy --check advises: each note where its cause is, and not elsewhere.
emmy=$1
source=$2
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
failed=0
n=0
has() # TEXT COMMAND-LINE...: its output has the text
{
  text=$1
  shift
  n=$((n + 1))
  "$emmy" --check "$@" >"$work/out" 2>&1
  grep -qF -- "$text" "$work/out" || { echo "FAILED: no <$text> for $*"; failed=1; }
}
lacks()
{
  text=$1
  shift
  n=$((n + 1))
  "$emmy" --check "$@" >"$work/out" 2>&1
  ! grep -qF -- "$text" "$work/out" || { echo "FAILED: <$text> for $*"; failed=1; }
}
block=$source/prm/examples/block.prm
# c = sqrt(134615/1000) = 11.6 m/s, a step of 0.5 h/c
has 'P-waves run 11.6024 m/s, 0.5 cells a step; 10 steps a period resolve waves of 5 cells' "$block"
has 'particles a cell      16' "$block"
for text in 'Is the modulus' 'Are lengths in mm' 'no solid' 'faster than' 'on faces' 'another body' 'Points per direction cost'; do
  lacks "$text" "$block"
done
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
echo "$n checks"
exit $failed
