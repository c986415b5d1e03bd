#!/bin/sh
# Two discs that meet, prm/examples/two-discs.prm, on cells of 0.5 m with 2x2
# particles, beside smaller cells and beside cells of 2 m with 35x35 particles:
# when they touch and part, the largest strain energy, and what is kept as strain
# afterwards, as they vibrate: the mean from 7 to 11 s. Fails if that of the scene
# is more than that of the many particles by above 3 % of the energy there is, or
# if discs do not part. How near they come before they touch is printed by
# test_contact_scenes. Two minutes on an idle core.
#
#   tests/performance/two_discs.sh [BUILD_FOLDER]      default: build
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "${1:-build}" && pwd)
[ -x "$build/emmy" ] || { echo "no $build/emmy: build it first" >&2; exit 2; }
. "$(dirname "$0")/scratch.sh"
cd "$work"

# discs SETTINGS...: touch, part, largest strain energy, that kept, balance,
# iterations, end, energy there is
discs()
{
  "$build/emmy" "$root/prm/examples/two-discs.prm" --set Output/Directory=run \
    --set "Time/End time=11" \
    --set Output/Frames=0 --set Output/Pictures=false --overwrite "$@" >out ||
    { cat out >&2; exit 1; }
  awk -F, '
    NR == 2 { energy = $c["kinetic_energy"] }
    NR == 1 { for (i = 1; i <= NF; ++i) c[$i] = i; next }
    { t = $c["time"]; S = $c["strain_energy"]; e = $c["balance_error"]
      if ($c["contact_pairs"] > 0) { if (!touch) touch = t; part = t }
      if (S > most) most = S
      if (t >= 7) { kept += S; ++m }
      if (e < 0) e = -e
      if (e > error) error = e
      n += $c["newton_iterations"] }
    END { printf "%.2f %.2f %.3f %.3f %.1e %.1f %.2f %.6f\n", touch, part, most,
            kept / m, error, n / (NR - 2), t, energy }' run/ledger.csv
}

echo "| discs | touch, s | last touch, s | strain energy, most, J | kept, J | balance error, J | Newton |"
echo "|---|---|---|---|---|---|---|"
row()
{
  name=$1
  shift
  figures=$(discs "$@")
  # shellcheck disable=SC2086
  set -- $figures
  echo "| $name | $1 | $2 | $3 | $4 | $5 | $6 |"
  awk -v part="$2" -v end="$7" 'BEGIN { exit !(part < end - 0.5) }' ||
    { echo "FAILED: they do not part"; exit 1; }
  kept=$4 energy=$8
}
row "0.5 m, 2x2"
scene=$kept
row "0.5 m, 2x2, Stiffness factor = 0.3" --set "Effects/Contact/Stiffness factor=0.3"
softer=$kept
row "0.25 m, 2x2, Stiffness factor = 0.3" --set "Grid/Cells=80, 48" \
  --set "Effects/Contact/Stiffness factor=0.3"
smaller=$kept
row "2 m, 35x35, Stiffness factor = 0.3" --set "Grid/Cells=10, 6" \
  --set "Bodies/left/Points per direction=35" \
  --set "Bodies/right/Points per direction=35" \
  --set "Effects/Contact/Points per direction=1" \
  --set "Effects/Contact/Stiffness factor=0.3"
awk -v a="$scene" -v b="$softer" -v c="$smaller" -v many="$kept" -v energy="$energy" '
  function share(kept) { return 100 * (kept - many) / energy }
  BEGIN {
    print "kept as strain beyond that of many particles, of the energy there is:"
    printf "%.2f %% (at most 3 %%); with Stiffness factor = 0.3 %.2f %%, and with", share(a), share(b)
    printf " cells of 0.25 m %.2f %%\n", share(c)
    exit !(share(a) <= 3) }' || { echo "FAILED: more than 3 %"; exit 1; }
