#!/bin/sh
# A disk that fills up, file by file: emmy says which file, and that the disk
# may be full; it ends with exit code 1 on all ranks; files are whole or absent.
#
# Usage: full_disk.sh EMMY SOURCE_ROOT MPI_LAUNCHER
set -u

[ $# -eq 3 ] || { echo "usage: full_disk.sh EMMY SOURCE_ROOT MPI_LAUNCHER" >&2; exit 2; }
# A small disk is mounted where no one else sees it; it goes with this script.
if [ -z "${EMMY_MOUNTS-}" ]; then
  for rights in -m -rm; do
    if unshare $rights true 2>/dev/null; then
      EMMY_MOUNTS=yes exec unshare $rights sh "$0" "$@"
    fi
  done
fi
# shellcheck source=tests/program/checks.sh
. "$2/tests/program/checks.sh"
emmy=$(absolute "$1")
launcher=$3
cd "$work" || exit 2
{
  tiny_scene
  printf 'subsection Output\nset Directory = full/run\nend\n'
} >scene.prm

# stops_at NAME FILE: the last run did, in words
stops_at()
{
  check "$1: exit code 1" [ "$status" -eq 1 ]
  check "$1: one error" has_lines 1 "$work/err" '^emmy: error: [^ ]'
  check "$1: nothing unexpected" not says "$work/err" unexpected
  check "$1: names the file" matches "$work/err" "$2"
  check "$1: says what to do" says "$work/err" 'that the disk is not full'
}

echo "One file that cannot be written"
# those that are written aside are named so
for file in run.log parameters.prm.new particles_0000.0.vtu.new particles_0000.pvtu.new \
  particles.pvd.new fields.txt.new grid_0001.0.vtu.new grid_0001.pvtu.new grid.pvd.new timing.json.new; do
  rm -rf full && mkdir -p full/run
  ln -s /dev/full "full/run/$file"
  emmy_run scene.prm
  stops_at "$file" "run/${file%.new}> cannot be written"
  check "$file: nothing stays aside" [ -z "$(find full -name '*.new')" ]
done
rm -rf full && mkdir -p full/run
ln -s /dev/full full/run/particles_0000.1.vtu.new
run_on_two_ranks scene.prm
stops_at 'second of two ranks' 'run/particles_0000.1.vtu> cannot be written'

echo "A small disk"
# on_disk SIZE RUNNER ARGUMENTS...: on a fresh disk of so many kB
on_disk()
{
  size=$1 runner=$2
  shift 2
  mkdir -p full
  mount -t tmpfs -o "size=${size}k" tmpfs full 2>/dev/null || return 1
  "$runner" scene.prm "$@"
  left=$(find full -name '*.new')
  # columns of the ledger's whole lines; what ends without a line break was cut
  torn=$(find full -name '*.p*' -o -name '*.vtu' -o -name '*.json' | while read -r file; do
    [ "$(tail -c 1 "$file" | od -An -c | tr -d ' ')" = '\n' ] || echo "$file"
  done)
  umount full
}
for size in 8 16 24 32 48 64 96 128; do
  for runner in emmy_run run_on_two_ranks; do
    for frames in Grid Particle; do
      name="$size kB, $runner, no $frames files"
      if on_disk $size $runner --set "Output/$frames files=false" --set 'Output/Frames=100' \
        --set 'Time/End time=3' --set 'Time/Step size=0.03'; then
        stops_at "$name" '<full/run[^>]*> cannot be written|folder <full/run>'
        check "$name: nothing stays aside" [ -z "$left" ]
        check "$name: files are whole or absent" [ -z "$torn" ]
      else
        skip "$name" 'no disk can be mounted here'
      fi
    done
  done
done

echo "A screen that takes nothing"
# to_full ARGUMENTS...: emmy's output goes to a full disk
to_full()
{
  last_run="$* >/dev/full"
  status=0
  "$timeout" 60 "$emmy" "$@" >/dev/full 2>"$work/err" </dev/null || status=$?
}
for arguments in --help --list --print-parameters 'study --print-parameters' '--check scene.prm' 'scene.prm --overwrite'; do
  rm -rf full
  # shellcheck disable=SC2086
  to_full $arguments
  check "$arguments: exit code 1" [ "$status" -eq 1 ]
  check "$arguments: says so" says "$work/err" 'that the disk is not full'
done
check 'the results are there' [ -s full/run/timing.json ]

finish
