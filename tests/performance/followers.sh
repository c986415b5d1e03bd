#!/bin/sh
# What Starved nodes = follow costs where no node starves: instructions of a step
# of a column that rests on the ground, against those with free. Two runs of
# different length are subtracted, so that the start does not count. Counts need
# no quiet machine. Fails above 2 %. Takes a minute.
#
#   tests/performance/followers.sh [BUILD_FOLDER]      default: build
#
# Counts are those of valgrind: apt-get install valgrind.
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "${1:-build}" && pwd)
[ -x "$build/emmy" ] || { echo "no $build/emmy: build it first" >&2; exit 2; }
. "$(dirname "$0")/scratch.sh"
need_valgrind
cd "$work"

few=3
many=9
limit=2 # %

# instructions CHOICE STEPS
instructions()
{
  valgrind --tool=callgrind --callgrind-out-file=/dev/null --log-file=counts \
    "$build/emmy" "$root/prm/validation/slow-column.prm" \
    --set "Method/Starved nodes=$1" --set "Time/Maximum steps=$2" \
    --set Output/Directory=run --set Output/Frames=0 \
    --set Output/Pictures=false --overwrite >out 2>&1 ||
    { cat out >&2; exit 1; }
  awk '/Collected/ { print $4 }' counts
}

free=$(($(instructions free $many) - $(instructions free $few)))
follow=$(($(instructions follow $many) - $(instructions follow $few)))
starved=$(awk -F, '!column { for (i = 1; i <= NF; ++i)
                               if ($i == "followers") column = i; next }
                   $column > most { most = $column } END { print most + 0 }' \
  run/ledger.csv)
awk -v free="$free" -v follow="$follow" -v n="$((many - few))" \
  -v starved="$starved" -v limit="$limit" 'BEGIN {
    more = 100 * (follow / free - 1)
    printf "instructions of a step: free %.4g, follow %.4g: %.2f %% more", \
      free / n, follow / n, more
    printf " (at most %g %%); followers: %d (0)\n", limit, starved
    exit (more > limit || starved > 0)
  }'
