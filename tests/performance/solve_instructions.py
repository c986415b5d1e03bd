#!/usr/bin/env python3
"""Instructions that a rank takes for a step and its linear solves, part by part, for
the beam in space of prm/benchmarks; counted by callgrind, so on any busy machine. What
it waits for other ranks counts too. For doc/performance.md.

  solve_instructions.py EMMY SOURCE_ROOT MPI_LAUNCHER [--ranks 1,2] [--cells 52]
                        [--step 2] [--functions GIMP] [--geometry middle]
"""
import argparse
import glob
import os
import re
import subprocess
import sys
import tempfile

ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS="1", DEAL_II_NUM_THREADS="1",
                   OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
STEP = "Scene<3>::advance"
# a part, and the functions that it is, with all that they call
PARTS = [("step", [STEP]),
         ("stencils, gather", ["TimeIntegrator<3>::ground_at_start"]),
         ("particles to grid", ["Stepper<3>::renew_grid"]),
         ("velocity from momentum", ["Stepper<3>::velocity_from_momentum"]),
         ("accounts", ["Stepper<3>::move", "Stepper<3>::follow", "Stepper<3>::report"]),
         ("grid to particles", ["TimeIntegrator<3>::accept"]),
         ("residual and tangent", ["StepEquation<3>::evaluate"]),
         ("linear solve", ["Newton::Iteration::find_increment"]),
         ("- coarse level, made", ["CoarseBoxes<3>::make"]),
         ("- coarse level, applied", ["CoarseBoxes<3>::correct"]),
         ("- ILU, made", ["BlockIlu<3>::make"]),
         ("- ILU, applied", ["BlockIlu<3>::substitute"]),
         ("- products with the matrix", ["NodeProduct::vmult", "Epetra_CrsMatrix::Multiply"])]


def instructions(name):
    """Of each function, in millions: of its largest line."""
    text = subprocess.run(["callgrind_annotate", "--inclusive=yes", "--threshold=100", name],
                          stdout=subprocess.PIPE, check=True).stdout.decode(errors="replace")
    found = {}
    for number, function in re.findall(r"^\s*([\d,]+) \([^)]*\)\s+[^:]*:emmy::(?:\(anonymous "
                                       r"namespace\)::)?([\w:<>]+)\(", text, re.M):
        found[function] = max(found.get(function, 0.), int(number.replace(",", "")) / 1e6)
    for number in re.findall(r"^\s*([\d,]+) \([^)]*\)\s+[^:]*:(?:Epetra_CrsMatrix::Multiply\()",
                             text, re.M):
        found["Epetra_CrsMatrix::Multiply"] = int(number.replace(",", "")) / 1e6
    return found


def run(arguments, n_ranks, work):
    grid = ", ".join(str(n) for n in (arguments.cells, arguments.cells * 3 // 4,
                                      arguments.cells * 3 // 4))
    command = [arguments.launcher, "--oversubscribe", "--mca", "mpi_yield_when_idle", "1", "-np",
               str(n_ranks), "valgrind", "--tool=callgrind", "--callgrind-out-file=count.%p",
               f"--dump-after=emmy::{STEP}()",
               os.path.abspath(arguments.emmy),
               os.path.join(os.path.abspath(arguments.root), "prm/benchmarks/cantilever-3d.prm")]
    for setting in [f"Grid/Cells={grid}", f"Time/Maximum steps={arguments.step}", "Output/Frames=0",
                    "Output/Directory=run", "Time/Factor=15", f"Method/Shape functions={arguments.functions}",
                    f"Method/Geometry={arguments.geometry}"]:
        command += ["--set", setting]
    done = subprocess.run(command, cwd=work, env=ENVIRONMENT, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode != 0:
        sys.exit(f"FAILED: {' '.join(command)}\n{done.stdout.decode(errors='replace')}")
    # a file for each step; those of the last
    names = sorted(glob.glob(os.path.join(work, f"count.*.{arguments.step}")))
    return [instructions(name) for name in names]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("emmy")
    parser.add_argument("root")
    parser.add_argument("launcher")
    parser.add_argument("--ranks", type=lambda text: [int(n) for n in text.split(",")],
                        default=[1, 2])
    parser.add_argument("--cells", type=int, default=52)
    parser.add_argument("--step", type=int, default=2)
    parser.add_argument("--functions", default="linear")
    parser.add_argument("--geometry", default="start")
    arguments = parser.parse_args()
    found = []
    for n_ranks in arguments.ranks:
        with tempfile.TemporaryDirectory() as work:
            found.append(run(arguments, n_ranks, work))
    print(f"| {arguments.cells} cells, step {arguments.step}, 1e6 instructions |"
          + "".join(f" {len(ranks)} ranks |" for ranks in found))
    print("|---" * (1 + len(found)) + "|")
    for part, functions in PARTS:
        print(f"| {part} |" + "".join(
            " " + ", ".join(f"{sum(rank.get(f, 0.) for f in functions):.0f}" for rank in ranks)
            + " |" for ranks in found))


main()
