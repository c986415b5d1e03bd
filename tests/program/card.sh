#!/bin/sh
# The scene card: what emmy says of each effect agrees with the scene that it
# builds, and with what the run then writes; --list names what there is.
#
# Usage: card.sh EMMY SOURCE_ROOT
set -u

[ $# -eq 2 ] || { echo "usage: card.sh EMMY SOURCE_ROOT" >&2; exit 2; }
# shellcheck source=tests/program/checks.sh
. "$2/tests/program/checks.sh"
emmy=$(absolute "$1")
root=$(absolute "$2")
cd "$work" || exit 2
# a block of 2 x 2 cells in flight
tiny_scene | sed 's/Upper corner = 2, 2/Upper corner = 3, 3/' >base.prm

echo "List"
emmy_run --list
check '--list: exit code 0' [ "$status" -eq 0 ]
cp out list
# listed NAME: one line with a description
listed()
{
  check "--list: $1" has_lines 1 list "^  $1  +[^ ].{9}"
}
# known ENTRY VALUE...: the names that an error about a wrong value lists
known()
{
  emmy_run --check base.prm --set "$1=nonsense"
  tr -s ' \n' '  ' <err | sed -e 's/.*Known are: //' -e 's/\..*//' -e 's/, /,/g'
}
for entry in Effects/Names Materials/rubber/Model Bodies/block/Shape; do
  names=$(known "$entry")
  check "--list: $entry knows names" [ "$(echo "$names" | tr , '\n' | grep -c .)" -ge 2 ]
  while [ -n "$names" ]; do
    listed "${names%%,*}"
    case $names in *,*) names=${names#*,} ;; *) names= ;; esac
  done
done
# patterns are in the reference: "# ... Default: linear. Possible values: linear|GIMP"
for name in linear GIMP particle extent automatic direct GMRES BiCGStab Jacobi ILU ML; do
  listed $name
done
check '--list: seven groups' has_lines 7 list '^[a-zB-Z].*\(.*/.*\)$'

echo "Errors"
# refused NAME WORDS ARGUMENTS...: an error that says so
refused()
{
  name=$1 words=$2
  shift 2
  emmy_run "$@"
  check "$name: exit code 1" [ "$status" -eq 1 ]
  check "$name: says why" says err "$words"
  check "$name: a remedy" says err 'Remedy:'
}
refused '--all alone' 'no parameter file' --all
refused '--all with a study' '--all without a scene' study --all base.prm
refused '--all with --list' '--all without a scene' --list --all
emmy_run --all base.prm --set Output/Directory=all
check '--all with a run: its head has what is absent' matches all/run.log '^    aggregation .*constraints of all solves'
refused '--list with a file' '--list with <base.prm>' --list base.prm
refused '--list with --set' '--list with <--set>' --list --set 'Time/Factor=2'
refused '--check --all alone' 'no parameter file' --check --all

# The card of a scene, as lines "present|absent NAME;bytes;nonzeros;fields;ledger"
card()
{
  awk '
    function close_effect()
    {
      if (name != "")
        print kind " " name ";" bytes ";" nonzeros ";" fields ";" ledger
      name = fields = ledger = ""
    }
    /^  present +bytes/ { kind = "present"; next }
    /^  absent +bytes/ { close_effect(); kind = "absent"; next }
    !/^  / { close_effect(); kind = "" }
    kind == "" { next }
    /^    [^ ]/ {
      close_effect()
      name = substr($0, 5, 22); sub(/ +$/, "", name)
      rest = substr($0, 27); split(rest, column, " ")
      bytes = column[1]; nonzeros = column[2]
      if (name == "every particle") {
        nonzeros = 0; fields = rest
        sub(/.*position, id, /, "", fields)
      }
      next
    }
    $1 == "fields" { sub(/^ *fields /, ""); fields = $0 }
    $1 == "ledger" { sub(/^ *ledger /, ""); ledger = $0 }
    END { close_effect() }'
}
# of CARD LINE COLUMN: a column of the line that starts so
of()
{
  awk -F ';' -v line="$2" -v column="$3" '$1 == line { print $column }' "$1"
}
# listing CARD COLUMN: all items of a column of the effects that are present
listing()
{
  awk -F ';' -v column="$2" '/^present/ && $1 != "present all" { print $column }' "$1" |
    sed 's/, /\n/g' | grep . | sort -u
}

emmy_run --check --all base.prm
check 'base: exit code 0' [ "$status" -eq 0 ]
card <out >base.card
check 'base: 3 x 3 nodes, of which opposite corners share no cell' \
  [ "$(of base.card 'present all' 3)" -eq $(((4 * 4 + 4 * 6 + 9) * 4)) ]
check 'base: ghost faces couple all but opposite corners' \
  [ "$(of base.card 'absent ghost stabilisation' 3)" = +$(((81 - 4) * 4 - 196)) ]
emmy_run --check base.prm
check 'base: absent effects have no numbers unless asked for' has_lines 0 out '^  absent +bytes'
check 'base: absent effects are named' \
  says out 'absent von Mises, Drucker-Prager, neo-Hooke, stress rule, locking treatment, explicit steps, static steps, GIMP, domain update, middle geometry, aggregation, gravity, point load, surface loads, mass damping, viscous sides, contact, tools, ghost stabilisation, manufactured solution, lumping, PIC, inelastic walls, unconstrained walls, moving walls, held parts, reactions, contact sides, diagnosis, displacement output'

# agrees NAME CARD_NAME ARGUMENTS...: with the arguments the scene has the
# effect; its card agrees with the run, and with what the scene without it says
agrees()
{
  name=$1 effect=$2
  shift 2
  emmy_run "$@" --check
  check "$name: --check succeeds" [ "$status" -eq 0 ]
  card <out >check.card
  emmy_run "$@" --set 'Output/Directory=results' --set 'Time/Maximum steps=2' --overwrite \
    --set 'Output/Particle fields=carried'
  check "$name: the run succeeds" [ "$status" -eq 0 ]
  card <results/run.log >run.card
  check "$name: the head of the run is the card" cmp -s check.card run.card
  sed -n '/^particles.pvd/,/^$/p' results/fields.txt |
    sed -n 's/^\([a-z_]*\) \[.*/\1/p' | grep -v '^id$' | sort >there
  listing run.card 4 >told
  check "$name: its fields are in the files" cmp -s there told
  head -n 1 results/ledger.csv | tr , '\n' | grep -vxE \
    'step|time|time_step|kinetic_energy(_grid_old|_grid_new)?|residual_work|balance_error|(linear|angular)_momentum_[xyz]|(newton|linear)_iterations|active_(cells|dofs)|particles|hidden_(kinetic_energy|share)|overfill' |
    sort >there
  listing run.card 5 >told
  check "$name: its columns are in the ledger" cmp -s there told
  check "$name: bytes add up" [ "$(
    awk -F ';' '/^present/ && $1 != "present all" { sum += $2 } END { print sum }' run.card
  )" -eq "$(of run.card 'present all' 2)" ]
  check "$name: bytes are those of a particle" \
    says results/run.log "numbers each, $(of run.card 'present all' 2) bytes,"
  [ -n "$effect" ] || return
  check "$name: present" [ "$(of run.card "present $effect" 1)" = "present $effect" ]
  check "$name: absent before" [ "$(of "$base" "absent $effect" 1)" = "absent $effect" ]
  for column in 2 3 4 5; do
    check "$name: column $column is as foretold" \
      [ "$(of run.card "present $effect" $column)" = "$(of "$base" "absent $effect" $column)" ]
  done
  check "$name: nonzeros are those of the matrix" is "$(of run.card 'present all' 3) == \
    $(of "$base" 'present all' 3) + $(of run.card "present $effect" 3)"
}

echo "Effects"
base=base.card
agrees 'base' '' base.prm
agrees 'gravity' gravity base.prm --set 'Effects/Names=gravity' \
  --set 'Effects/Gravity/Acceleration=0, -1'
agrees 'point load' 'point load' base.prm --set 'Effects/Names=point load' \
  --set 'Effects/Point load/Force=1; 0' --set 'Effects/Point load/Points nearest to=3, 3'
agrees 'manufactured' 'manufactured solution' base.prm --set 'Bodies/block/Initial velocity=0; 0' \
  --set 'Effects/Names=manufactured solution' --set 'Effects/Manufactured solution/Period=1' \
  --set 'Effects/Manufactured solution/vibration/Lower corner=1, 1' \
  --set 'Effects/Manufactured solution/vibration/Upper corner=3, 3' \
  --set 'Effects/Manufactured solution/vibration/Amplitude=0.1, 0.1'
floor='Effects/Tools/floor'
agrees 'tools' '' base.prm --set 'Effects/Names=tools' --set 'Effects/Tools/Names=floor, grip' \
  --set "$floor/Shape=plane" --set "$floor/Reference point=0, 0.9" --set "$floor/plane/Normal=0, 1" \
  --set "$floor/Friction coefficient=0.5" --set "$floor/Rotation=0.1*t" \
  --set 'Effects/Tools/grip/Shape=plane' --set 'Effects/Tools/grip/Reference point=3, 1' \
  --set 'Effects/Tools/grip/plane/Normal=-1, 0' --set 'Effects/Tools/grip/Holds=true'
agrees 'ghosts' 'ghost stabilisation' base.prm --set 'Effects/Names=ghost stabilisation'
agrees 'lumping' lumping base.prm --set 'Method/Lumping=0.5'
agrees 'PIC' PIC base.prm --set 'Method/Mapping=PIC'
agrees 'end-point' 'stress rule' base.prm --set 'Method/Stress rule=end-point'
agrees 'mean dilatation' 'locking treatment' base.prm --set 'Method/Locking treatment=cell'
agrees 'mean dilatation, GIMP' 'locking treatment' base.prm --set 'Method/Locking treatment=cell' \
  --set 'Method/Shape functions=GIMP' --set 'Method/Geometry=start'
agrees 'explicit' '' base.prm --set 'Time/Integrator=explicit'
check 'explicit: present' [ "$(of run.card 'present explicit steps' 5)" = velocity_update_loss ]
check 'explicit: lumped' [ "$(of run.card 'present lumping' 5)" = lumping_loss ]
check 'explicit: no matrix' [ "$(of run.card 'present all' 3)" -eq 0 ]
agrees 'diagnosis' diagnosis base.prm --set 'Diagnosis/Small cuts=true'
agrees 'middle' 'middle geometry' base.prm --set 'Method/Geometry=middle'
agrees 'GIMP' GIMP base.prm --set 'Method/Shape functions=GIMP' --set 'Method/Geometry=start'
check 'GIMP: the update of domains was foretold too' [ \
  "$(of run.card 'present domain update' 4)" = "$(of base.card 'absent domain update' 4)" ]
agrees 'held part' '' base.prm --set 'Boundary conditions/Held parts=plate' \
  --set 'Boundary conditions/plate/Region=y - 1.9' --set 'Boundary conditions/plate/Velocity=0; free'
agrees 'moving wall' 'moving walls' base.prm --set 'Boundary conditions/Fixed=x-min' \
  --set 'Boundary conditions/Velocity of x-min=0; 0.1'
agrees 'measurements' '' base.prm --set 'Measurements/Names=tip, block' \
  --set 'Measurements/tip/Type=particle' --set 'Measurements/tip/Nearest to=2, 1.5' \
  --set 'Measurements/block/Type=extent'
check 'measurements: their columns' \
  [ "$(of run.card 'present measurement tip' 5)" = 'tip_x, tip_y' ]
sed -e 's/Hencky/von Mises/' -e "/Poisson/a set Yield stress = 2" base.prm >plastic.prm
agrees 'plastic' '' plastic.prm --set 'Method/Locking treatment=none'
for column in 2 4 5; do
  check "plastic: column $column is as foretold" \
    [ "$(of run.card 'present material rubber' $column)" = "$(of base.card 'absent von Mises' $column)" ]
done

echo "Where they matter"
# a block that hardly reaches beyond a cell: starved nodes at two sides
sed 's/Upper corner = 3, 3/Upper corner = 2.25, 2.25/' base.prm >cut.prm
emmy_run --check --all cut.prm --set 'Method/Starved threshold=0.2'
card <out >cut.card
base=cut.card
agrees 'cut, aggregation' aggregation cut.prm --set 'Method/Starved nodes=follow' --set 'Method/Starved threshold=0.2'
agrees 'cut, ghosts' 'ghost stabilisation' cut.prm --set 'Effects/Names=ghost stabilisation'
# both: without one, what the other alone has
emmy_run --check cut.prm --set 'Method/Starved nodes=follow' --set 'Method/Starved threshold=0.2' \
  --set 'Effects/Names=ghost stabilisation'
card <out >both.card
# adds NAME ARGUMENTS...: the same as a card of the other one foretells
adds()
{
  effect=$1
  shift
  emmy_run --check --all cut.prm --set 'Method/Starved threshold=0.2' "$@"
  card <out >one.card
  check "cut, both: what $effect adds" \
    [ "$(of both.card "present $effect" 3)" = "$(of one.card "absent $effect" 3)" ]
}
adds 'ghost stabilisation' --set 'Method/Starved nodes=follow'
adds aggregation --set 'Effects/Names=ghost stabilisation'
# walls
sed 's/Lower corner = 1, 1/Lower corner = 0, 1/' base.prm >wall.prm
emmy_run --check --all wall.prm --set 'Boundary conditions/Fixed=x-min'
card <out >wall.card
base=wall.card
for walls in inelastic unconstrained; do
  agrees "$walls" "$walls walls" wall.prm --set 'Boundary conditions/Fixed=x-min' \
    --set "Method/Wall mapping=$walls"
done
finish
