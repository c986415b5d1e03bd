#!/bin/sh
# What the choices of section Method, and walls that move, put into a scene:
# the numbers that a particle carries, the columns of the ledger, and nothing
# where they are not chosen.
#
# Usage: method.sh EMMY SOURCE_ROOT
set -u

[ $# -eq 2 ] || { echo "usage: method.sh EMMY SOURCE_ROOT" >&2; exit 2; }
# shellcheck source=tests/program/checks.sh
. "$2/tests/program/checks.sh"
emmy=$(absolute "$1")
root=$(absolute "$2")
cd "$work" || exit 2
mkdir run && cd run || exit 2
tiny_scene >base.prm

# a block that hits the floor askew, turning
cat >scene.prm <<'END'
include base.prm
subsection Bodies
  subsection block
    set Initial velocity = 0.5 - 0.5*(y - 1.5); -1 + 0.5*(x - 1.5)
  end
end
subsection Boundary conditions
  set Fixed = y-min
end
subsection Time
  set End time  = 1
  set Step size = 0.05
end
END

# scene FOLDER ARGUMENTS...: run it; every joule must be accounted for
scene()
{
  folder=$1
  shift
  emmy_run scene.prm --set "Output/Directory=$folder" --set 'Output/Frames=1' "$@"
  check "$folder: runs" [ "$status" -eq 0 ]
  check "$folder: balance" is "($(last "$folder" balance_error))^2 < 1e-26"
}

# carries FOLDER NUMBER: so many numbers per particle
carries()
{
  check "$1: $2 numbers a particle" matches "$1/run.log" "^ *particles .* $2 numbers each"
}

scene plain
check 'plain: columns' [ "$(columns plain)" = strain_energy ]
carries plain 14
check 'plain: the block does hit the floor' is "$(last plain strain_energy) > 1e-3"

echo "Bodies that sides of the grid cut"
bar=$root/prm/paper/7.4.prm
emmy_run "$bar" --check
quarter=$(sed -n 's/^ *particles *\([0-9]*\),.*/\1/p' "$work/out")
emmy_run "$bar" --check --set 'Bodies/bar/Cut by=' --set 'Grid/Cells=18, 50, 18' \
  --set 'Grid/Lower corner=-7.2e-3, 0, -7.2e-3'
whole=$(sed -n 's/^ *particles *\([0-9]*\),.*/\1/p' "$work/out")
check 'cut: a quarter of the bar has a quarter of its particles' is "$quarter > 0"
check 'cut: a quarter of the bar has a quarter of its particles' is "$whole == 4*$quarter"

echo "Domains"
start='Method/Geometry=start'
scene GIMP --set 'Method/Shape functions=GIMP' --set 'Method/Domain update=none' --set "$start"
check 'GIMP: columns' [ "$(columns GIMP)" = strain_energy ]
carries GIMP 16
scene middle --set 'Method/Shape functions=GIMP' --set 'Method/Domain update=none'
carries middle 22
for update in detF corners; do
  scene $update --set 'Method/Shape functions=GIMP' --set "Method/Domain update=$update" --set "$start"
  carries $update 16
done
for update in diagF stretch; do
  scene $update --set 'Method/Shape functions=GIMP' --set "Method/Domain update=$update" --set "$start"
  carries $update 20
  check "$update: the deformation gradient is in the output" \
    says $update/fields.txt deformation_gradient
done
check 'updates differ' not cmp -s detF/ledger.csv stretch/ledger.csv
scene unused --set 'Method/Domain update=corners'
check 'an update without GIMP changes nothing' cmp -s plain/ledger.csv unused/ledger.csv

echo "Mapping and mass"
scene PIC --set 'Method/Mapping=PIC'
check 'PIC: columns' [ "$(columns PIC)" = strain_energy,mapping_loss ]
carries PIC 14
check 'PIC: it loses energy' is "$(last PIC mapping_loss) > 1e-3"
scene blend --set 'Method/Mapping=blend' --set 'Method/FLIP fraction=0.9'
check 'blend: it loses energy' is "$(last blend mapping_loss) > 1e-4"
scene all-flip --set 'Method/Mapping=blend' --set 'Method/FLIP fraction=1'
check 'a blend of FLIP alone is FLIP' cmp -s plain/ledger.csv all-flip/ledger.csv
for epsilon in 0.3 1; do
  scene lumped --overwrite --set "Method/Lumping=$epsilon"
  check "lumping $epsilon: columns" [ "$(columns lumped)" = strain_energy,lumping_loss ]
  check "lumping $epsilon: it loses energy" is "$(last lumped lumping_loss) > 1e-4"
done

echo "Walls"
scene bounce --set 'Method/Wall mapping=unconstrained'
check 'unconstrained: columns' [ "$(columns bounce)" = strain_energy ]
scene inelastic --set 'Method/Wall mapping=inelastic'
check 'inelastic: columns' [ "$(columns inelastic)" = strain_energy,wall_loss ]
check 'inelastic: the wall takes energy' is "$(last inelastic wall_loss) > 1e-3"
scene moving --set 'Boundary conditions/Velocity of y-min=0.3*sin(2*pi*t); 0.03*sin(2*pi*t)'
check 'moving: columns' [ "$(columns moving)" = strain_energy,reaction_work ]
carries moving 14
check 'moving: the wall does work' is "($(last moving reaction_work))^2 > 1e-6"
scene carried --set 'Bodies/block/Initial velocity=0; 0' \
  --set 'Bodies/block/box/Lower corner=1, 0' --set 'Boundary conditions/Velocity of y-min=0.1; 0'
check 'a wall carries along a block at rest' is "$(last carried linear_momentum_x) > 1e-3"
scene still --set 'Boundary conditions/Velocity of y-min=0; 0*t'
check 'a wall of velocity zero rests' \
  [ "$(last still kinetic_energy)" = "$(last plain kinetic_energy)" ]

scene no-walls --set 'Boundary conditions/Fixed=' --set 'Method/Wall mapping=inelastic' \
  --set 'Time/End time=0.2'
check 'a wall mapping without walls: no column' [ "$(columns no-walls)" = strain_energy ]

echo "Ghost stabilisation"
ghosts='Effects/Ghost stabilisation'
scene unnamed --set "$ghosts/Mass penalty=0.1"
check 'not named: the same ledger' cmp -s plain/ledger.csv unnamed/ledger.csv
scene ghosts --set 'Effects/Names=ghost stabilisation'
check 'ghosts: columns' [ "$(columns ghosts)" = strain_energy,ghost_stiffness_loss,ghost_mass_loss ]
carries ghosts 14
check 'ghosts: both lose energy' \
  is "$(last ghosts ghost_mass_loss) > 1e-4 && $(last ghosts ghost_stiffness_loss) > 1e-6"
scene less --set 'Effects/Names=ghost stabilisation' --set "$ghosts/Stiffness penalty=0"
check 'no stiffness: none is lost' [ "$(last less ghost_stiffness_loss)" = 0 ]

echo "Starved nodes"
scene idle --set 'Method/Starved threshold=0.3'
check 'not named: the same ledger' cmp -s plain/ledger.csv idle/ledger.csv
scene aggregated --set 'Method/Starved nodes=follow'
check 'aggregation: nothing is lost' [ "$(columns aggregated)" = strain_energy ]
carries aggregated 14
check 'aggregation: what it did' \
  says aggregated/ledger.csv followers,free_starved,farthest_root,largest_weight,class_changes

echo "The examples of the paper"
# paper SCENE NUMBERS BYTES COLUMNS: what a particle carries, what the ledger holds
paper()
{
  emmy_run "$root/prm/paper/$1.prm" --set "Output/Directory=$1" --set 'Output/Frames=0' \
    --set 'Output/Pictures=false' --set 'Time/Maximum steps=1'
  check "$1: runs" [ "$status" -eq 0 ]
  check "$1: bytes a particle" matches "$1/run.log" "^ *particles .* $2 numbers each, $3 bytes"
  check "$1: columns" [ "$(columns "$1")" = "$4" ]
}
paper 7.1a 21 204 strain_energy,load_work
paper 7.1b 21 204 strain_energy,load_work
paper 7.2 14 148 strain_energy
paper 7.3a 21 204 strain_energy,hardening_energy,plastic_dissipation
paper 7.3b 27 252 strain_energy,hardening_energy,plastic_dissipation
paper 7.4 40 372 strain_energy,hardening_energy,plastic_dissipation,ghost_stiffness_loss,ghost_mass_loss

finish
