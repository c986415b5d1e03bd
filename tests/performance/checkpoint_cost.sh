#!/bin/sh
# What a checkpoint in every step costs: a block in three dimensions, with 4^3
# particles a cell, that falls onto a floor. Prints the particles, the size of a
# checkpoint, the seconds of a step without it, those of a checkpoint, and its
# share of the step. It should be below 10 %. Takes some minutes.
#
#   tests/performance/checkpoint_cost.sh [EMMY [CELLS [RANKS]]]   default: build/emmy 16 1
set -eu

emmy=${1:-build/emmy}
cells=${2:-16}
ranks=${3:-1}
[ -x "$emmy" ] || { echo "no $emmy: build it first" >&2; exit 2; }
emmy=$(cd "$(dirname "$emmy")" && pwd)/$(basename "$emmy")
work=$(mktemp -d "${TMPDIR:-.}/checkpoint_cost.XXXXXX") # a disk, not memory
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM
cd "$work"
export OMP_NUM_THREADS=1 DEAL_II_NUM_THREADS=1
grid=$((cells * 3 / 2))
cat >block.prm <<END
set Dimension = 3
subsection Grid
  set Lower corner = 0, 0, 0
  set Upper corner = 1.5, 1.5, 1.5
  set Cells        = $grid, $grid, $grid
end
subsection Materials
  set Names = rubber
  subsection rubber
    set Model           = Hencky
    set Density         = 1000
    set Young's modulus = 1e5
    set Poisson's ratio = 0.3
  end
end
subsection Bodies
  set Names = block
  subsection block
    set Shape                = box
    set Material             = rubber
    set Points per direction = 4
    subsection box
      set Lower corner = 0.25, 0.25, 0
      set Upper corner = 1.25, 1.25, 1
    end
  end
end
subsection Boundary conditions
  set Fixed = z-min
end
subsection Effects
  set Names = gravity
  subsection Gravity
    set Acceleration = 0, 0, -9.81
  end
end
subsection Time
  set End time      = 1
  set Step rule     = normalised
  set Factor        = 0.5
  set Maximum steps = 4
end
subsection Output
  set Directory = run
  set Frames    = 0
  set Pictures  = false
end
subsection Checkpoint
  set Every steps = 1
end
END
mpirun --oversubscribe -np "$ranks" "$emmy" block.prm >out 2>&1 || { cat out >&2; exit 1; }
size=$(du -sk run/checkpoints/step-00000004 | cut -f 1)
# a line of the table: calls, seconds of the slowest rank; setup is no part of a step
awk -v size="$size" -v ranks="$ranks" '
  /"total_seconds"/ { gsub(/[,:]/, ""); total = $2 }
  /"name"/ { name = $0; gsub(/.*: "|".*/, "", name) }
  /"seconds":/ { value = $2; gsub(/,/, "", value)
                 if (name == "checkpoint" && !found) { checkpoint = value; found = 1 }
                 if (name == "setup" || name == "scene card" || name == "pictures") others += value }
  END {
    step = (total - checkpoint - others) / 4
    printf "ranks %d, a checkpoint %.1f MB, step %.2f s, checkpoint %.3f s, share %.2f %%\n",
           ranks, size / 1024, step, checkpoint / 4, 100 * checkpoint / 4 / step
  }' run/timing.json
sed -n 's/^ *particles  */particles /p' out | head -n 1
