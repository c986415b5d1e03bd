#!/bin/bash
#SBATCH --job-name=emmy
#SBATCH --ntasks=32
#SBATCH --time=24:00:00
#SBATCH --signal=B:USR1@600
#SBATCH --requeue
#SBATCH --open-mode=append
#
# A run that is longer than a job: ten minutes before the time is up Slurm warns
# this script (USR1), which tells emmy to finish its step and write a
# checkpoint; then the job goes back to the queue and goes on from there. Ten
# minutes must be longer than a step takes.
#
#   sbatch slurm.sh my-scene.prm results/my-scene
#
# The scene has `set Directory = results/my-scene` in its section Output, and a
# section Checkpoint, so that a node that breaks down costs little too.
set -u

scene=$1
results=$2
interrupted=75 # emmy's exit code: it can go on

if ls -d "$results"/checkpoints/step-*[0-9] >/dev/null 2>&1; then
  set -- --restart "$results"
elif [ -e "$results/ledger.csv" ]; then
  set -- "$scene" --overwrite # stopped before its first checkpoint
else
  set -- "$scene"
fi

mpirun -np "${SLURM_NTASKS:-2}" emmy "$@" &
run=$!
trap 'kill -USR1 $run' USR1 # mpirun hands it on to all ranks
# a signal ends wait, not the run
while kill -0 $run 2>/dev/null; do
  wait $run
done
wait $run
status=$?

if [ $status -eq $interrupted ] || [ $status -eq 138 ]; then # 138: warned while it started
  scontrol requeue "$SLURM_JOB_ID"
else
  exit $status
fi
