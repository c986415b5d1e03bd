#!/bin/sh
# An effect is all in one place: outside its own files its name occurs in the
# library of effects, the scene's defaults and messages only. So is the lattice
# of the grid: others ask a cell for its size, and rely on equal cells in a few
# places. Counts the files and names those that are too many.
#
# Usage: effect_names.sh SOURCE_ROOT
set -eu

[ $# -eq 1 ] || { echo "usage: effect_names.sh SOURCE_ROOT" >&2; exit 2; }
cd "$1"
[ -d source/effects ] || { echo "no source/effects in $PWD" >&2; exit 2; }

failed=0

# count NAME PATTERN OWN_FILES ALLOWED: at most so many other files
count()
{
  own=$(find include source -type f -path '*/effects/*' | grep -E "/($3)\.(h|cc)$") ||
    { echo "$1: no file is its own: $3" >&2; exit 2; }
  others=$(grep -rliE "$2" include source | grep -vxF "$own" || true)
  n=$(printf '%s' "$others" | grep -c . || true)
  printf '%-24s %2d of at most %d other files\n' "$1" "$n" "$4"
  if [ "$n" -gt "$4" ]; then
    printf '%s\n' "$others" | sed 's/^/  /'
    echo "  Give Effect (effects/effect.h) a hook instead of asking for $1."
    failed=1
  fi
}

# ghosts of MPI, entries that another rank owns, are none of ours
count 'ghost stabilisation' 'ghost.?(stab|face|mass|effect|stiff|penal)' \
  'ghost_stabilisation|ghost_faces' 4
# the choice, its threshold and its price; words of a scene, of an effect that is
# no more, of two remedies; what --check tells
count 'starved nodes' 'starved|aggregat' \
  'starved_nodes|aggregation|roots|families' 12
# examples in the words of --help, and of a comment
count 'gravity' 'gravity' 'gravity|field_load|effect' 5
count 'point load' 'point.?load' 'point_load|field_load' 2
# the parameters, who makes them, words of a scene, the column of a picture
count 'moving walls' 'moving.?wall|wall_(velocit|displace|travel)' 'moving_walls' 4
count 'wall mapping' 'wall.?mapping|(inelastic|unconstrained).?wall|wall_loss' \
  'wall_mapping' 5
# the library, the remedy for a side that moves along its normal, the parameters
# of sides that only push
count 'tools' 'effects/tool|<tools>|"tools"|tool_work' \
  'tools|tool_advice|tool_contact|tool_mesh|tool_motion|tool_parameters|tool_path|tool_push|tool_records|tool_shapes|tool_sides|tool_surface' 3
# the library
count 'contact' 'effects/(body_)?contact|BodyContact|contact_overlap' \
  'body_contact|contact_across|contact_exchange|contact_forces|contact_nodes|contact_pair|contact_parameters|contact_search|pair_law' 1
count 'manufactured solution' 'manufactured' \
  'manufactured_solution|exact_motion' 1

# equal cells: spacing of particles, GIMP, faces of ghosts, words of a scene, ...
equal=$(grep -rlE 'Lattice|cell_size' include source | grep -v /grid/ || true)
n=$(printf '%s' "$equal" | grep -c . || true)
printf '%-24s %2d of at most 8 files outside grid\n' 'equal cells' "$n"
if [ "$n" -gt 8 ]; then
  printf '%s\n' "$equal" | sed 's/^/  /'
  echo "  Ask the grid for size_of() a cell or size_at() a position."
  failed=1
fi
exit $failed
