#!/bin/sh
# Scenes of prm/examples with tools and contact: each gives the right value that
# its head names and closes its balance; how many iterations of Newton it takes.
# A minute.
#
# Usage: tool_examples.sh EMMY SOURCE_ROOT
set -u

[ $# -eq 2 ] || { echo "usage: tool_examples.sh EMMY SOURCE_ROOT" >&2; exit 2; }
# shellcheck source=tests/program/checks.sh
. "$2/tests/program/checks.sh"
emmy=$(absolute "$1")
examples=$(absolute "$2")/prm/examples
cd "$work" || exit 2

# ran SCENE ARGUMENTS...: into the folder SCENE, without pictures
ran()
{
  scene=$1
  shift
  emmy_run "$examples/$scene.prm" --set "Output/Directory=$scene" \
    --set Output/Pictures=false --set Output/Frames=0 "$@"
  check "$scene: exit code 0" [ "$status" -eq 0 ]
}

# value SCENE EXPRESSION: of columns, at the end (last), at the start (first), or
# the largest size (most): "last(\"time\")"
value()
{
  awk -F, -v OFMT=%.17g '
    NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
    { for (i = 1; i <= NF; ++i) { if (NR == 2) start[i] = $i; end[i] = $i
        size = $i < 0 ? -$i : $i; if (size > largest[i]) largest[i] = size
        sum[i] += $i } }
    function last(c) { return end[column[c]] }
    function first(c) { return start[column[c]] }
    function most(c) { return largest[column[c]] }
    function mean(c) { return sum[column[c]] / (NR - 2) }
    END { print '"$2"' }' "$1/ledger.csv"
}

# near NAME VALUE RIGHT SHARE
near()
{
  echo "$1: $2, right $3"
  check "$1: $2 within $4 of $3" \
    awk -v a="$2" -v b="$3" -v t="$4" 'BEGIN { d = a / b - 1; exit !(d < t && -d < t) }'
}

# closes SCENE SCALE: its balance to 1e-12 of an energy
closes()
{
  error=$(value "$1" 'most("balance_error")')
  check "$1: balance error $error of $2 J" \
    awk -v e="$error" -v s="$2" 'BEGIN { exit !(e <= 1e-12 * s) }'
  mean=$(value "$1" 'mean("newton_iterations")')
  most=$(value "$1" 'most("newton_iterations")')
  echo "$1: iterations of Newton $mean, at most $most"
  check "$1: $mean iterations of Newton, at most 6 on average, and $most, at most 25" \
    awk -v a="$mean" -v b="$most" 'BEGIN { exit !(a <= 6 && b <= 25) }'
}

# Prandtl: (2 + pi) Y/sqrt(3) on half a metre
ran punch
near "punch, force of flow" "$(value punch 'last("tool_punch_force_y")')" 1.484e6 0.1
closes punch "$(value punch 'most("tool_punch_work")')"

# Coulomb: v^2/(2 mu g)
ran sled
near "sled, way" "$(value sled 'last("sled_x") - first("sled_x")')" 0.1699 0.05
closes sled 250

# Considere: the largest force
ran neck
near "neck, largest force" "$(value neck 'most("tool_grip_force_x")')" 2.915e5 0.01
check "neck: the force falls" awk -v a="$(value neck '-last("tool_grip_force_x")')" \
  -v b="$(value neck 'most("tool_grip_force_x")')" 'BEGIN { exit !(a < 0.95 * b) }'
closes neck "$(value neck 'most("tool_grip_work")')"
# what grip and wall bear is what the momentum loses, in each step
check "neck: forces are changes of momentum" awk -F, '
  NR == 1 { for (i = 1; i <= NF; ++i) c[$i] = i; next }
  { if (NR > 2) {
      f = $c["tool_grip_force_x"]; w = $c["wall_x_min_force_x"]; p = $c["linear_momentum_x"]
      d = p - before + $c["time_step"] * (f + w); if (d < 0) d = -d
      size = $c["time_step"] * (f < 0 ? -f : f)
      if (size > 0 && d / size > worst) worst = d / size }
    before = $c["linear_momentum_x"] }
  END { print "neck, force without change of momentum", worst; exit !(worst < 1e-10) }' \
  neck/ledger.csv

# a quarter of a cone, Sneddon: on a half-space, less what that moves by at the depth
# BASE (1/m: 0 is a half-space), where the block is held (Boussinesq)
sneddon()
{
  awk -v base="$1" 'BEGIN {
    E = 1e4; nu = 0.3; pi = atan2(0, -1); tangent = sin(pi * 75 / 180) / cos(pi * 75 / 180)
    # in the middle of the last step
    depth = 0.025 * (2 + (1 - cos(pi * 15 / 16)))
    F = 2 / pi * E / (1 - nu ^ 2) * tangent
    share = (1 + nu) * (3 - 2 * nu) / (2 * pi * E) * base * F
    # d - share d^2 = depth
    d = base > 0 ? (1 - sqrt(1 - 4 * share * depth)) / (2 * share) : depth
    printf "%.1f", F * d ^ 2 / 4 }'
}
ran cone
echo "cone, by the theory: $(sneddon 1) N, on a half-space $(sneddon 0) N"
# how the force comes to that: the radius of contact grows from nothing
awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) c[$i] = i; next }
  { z = $c["tool_cone_z"]
    if (NR == 2) start = z
    else {
      E = 1e4; nu = 0.3; pi = atan2(0, -1); h = 0.125
      tangent = sin(pi * 75 / 180) / cos(pi * 75 / 180)
      F = 2 / pi * E / (1 - nu ^ 2) * tangent
      share = (1 + nu) * (3 - 2 * nu) / (2 * pi * E) * F
      d = (1 - sqrt(1 - 4 * share * (start - (z + before) / 2))) / (2 * share)
      printf "cone, radius of contact %.2f cells: %.2f of the theory\n",
        2 / pi * d * tangent / h, $c["tool_cone_force_z"] / (F * d ^ 2 / 4) }
    before = z }' cone/ledger.csv
near "cone, force" "$(value cone 'last("tool_cone_force_z")')" "$(sneddon 1)" 0.03
closes cone "$(value cone 'most("tool_cone_work")')"

# half of a ring that bends, stretches and shears (Winkler's curved beam), pressed at
# the distance EDGE from its middle: N at 0.025 m
winkler()
{
  awk -v a="$1" 'BEGIN {
    E = 1e6; outer = 1; inner = 0.8; h = outer - inner; R = (outer + inner) / 2
    e = R - h / log(outer / inner); G = E / 2; n = 4000
    pi = atan2(0, -1); from = atan2(a, sqrt(outer ^ 2 - a ^ 2))
    for (i = 0; i < n; ++i) {
      t = (i + 0.5) * pi / 2 / n; on = t >= from
      # of a moment 1 at the top, which keeps it level, and of a force 1
      M = on ? R * sin(t) - a : 0; V = on ? cos(t) : 0; N = on ? -sin(t) : 0
      bend = 1 / (E * h * e * R); along = 1 / (E * h); both = 1 / (E * h * R)
      mm += bend; mf += M * bend + N * both
      ff += M * M * bend + 2 * M * N * both + N * N * along + 1.2 * V * V / (G * h) }
    printf "%.1f", 0.025 / ((ff - mf * mf / mm) * R * pi / 2 / n) }'
}
ran ring
echo "ring, by the theory: $(winkler 0.1333) N, pressed at its top $(winkler 0) N"
near "ring, force" "$(value ring 'last("tool_plate_force_y")')" "$(winkler 0.1333)" 0.03
closes ring "$(value ring 'most("tool_plate_work")')"

# others whose values are in tests of their own
ran press
closes press "$(value press 'most("tool_plate_work")')"
ran draw
closes draw "$(value draw 'most("tool_grip_work")')"
for scene in bounce two-discs; do
  ran $scene
  closes $scene "$(value $scene 'first("kinetic_energy")')"
done

# a hammer that flies off, and a side that only pushes
ran hammer
closes hammer 450
check "hammer: it flies off" awk -v p="$(value hammer 'last("tool_hammer_momentum")')" \
  'BEGIN { exit !(p < -100) }'
check "hammer: the floor has pushed" awk -v f="$(value hammer 'most("tool_y_min_force_y")')" \
  'BEGIN { exit !(f > 1e3) }'
finish
