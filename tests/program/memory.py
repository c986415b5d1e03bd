#!/usr/bin/env python3
"""What --check says that a run will need is what it takes at its peak, to 10 %;
and what that is above a run with next to no particles, to 12 %, where it is large.

  memory.py EMMY SOURCE_ROOT MPI_LAUNCHER
      some small scenes; fails if one is further off
  memory.py EMMY SOURCE_ROOT MPI_LAUNCHER --all
      more, and large ones: the table of doc/performance.md
"""
import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
from kills import ENVIRONMENT  # noqa: E402

BEAM, PLANE = "benchmarks/cantilever-3d.prm", "benchmarks/cantilever-2d.prm"
LINEAR = ["Method/Shape functions=linear", "Method/Geometry=start"]
GIMP = ["Method/Shape functions=GIMP", "Method/Geometry=start"]
MIDDLE = ["Method/Shape functions=GIMP", "Method/Geometry=middle"]


def cells(*numbers):
    return ["Grid/Cells=" + ", ".join(str(n) for n in numbers)]


# name, scene, what is set, steps, ranks; the first ones are the test
TEST = [
    ("beam, plane, linear, start", PLANE, LINEAR + cells(144, 108), 3, 1),
    ("beam, space, linear, start", BEAM, LINEAR + cells(52, 39, 39), 3, 1),
    ("beam, space, GIMP, middle", BEAM, MIDDLE + cells(32, 24, 24), 2, 1),
    ("beam, space, GIMP, middle", BEAM, MIDDLE + cells(16, 12, 12), 2, 2),
]
MORE = [
    ("beam, plane, GIMP, middle", PLANE, MIDDLE + cells(144, 108), 3, 1),
    ("beam, space, linear, start", BEAM, LINEAR + cells(52, 39, 39), 2, 2),
    ("beam, space, linear, start", BEAM, LINEAR + cells(96, 72, 72), 1, 1),
    ("beam, space, GIMP, start", BEAM, GIMP + cells(32, 24, 24), 3, 1),
    ("beam, space, GIMP, middle", BEAM, MIDDLE + cells(52, 39, 39), 2, 1),
    ("beam, space, explicit", BEAM,
     LINEAR + cells(52, 39, 39) + ["Time/Integrator=explicit", "Time/Factor=0.5"], 5, 1),
    ("beam, space, static", BEAM, LINEAR + cells(24, 18, 18) + ["Time/Integrator=static"], 2, 1),
    ("beam, plane, LU", PLANE, LINEAR + cells(144, 108) + ["Solver/Linear solver=direct"], 2, 1),
    ("beam, space, LU", BEAM, LINEAR + cells(20, 15, 15) + ["Solver/Linear solver=direct"], 2, 1),
    ("bar of copper", "benchmarks/taylor-bar.prm", LINEAR + cells(16, 76, 16), 3, 1),
    ("7.1b", "paper/7.1b.prm", [], 5, 1),
    ("7.2", "paper/7.2.prm", [], 20, 1),
    ("7.3b", "paper/7.3b.prm", [], 10, 1),
    ("7.4", "paper/7.4.prm", [], 2, 1),
    ("two balls, ghost stabilisation", "validation/two-balls.prm",
     ["Effects/Names=ghost stabilisation"], 3, 1),
    ("tools with friction", "examples/roll.prm", [], 5, 1),
    ("collapse of ground", "ground/collapse.prm", [], 5, 1),
]


def emmy(arguments, scene, settings, n_ranks, task):
    command = [os.path.abspath(arguments.emmy), *task,
               os.path.join(os.path.abspath(arguments.root), "prm", scene)]
    if n_ranks > 1:
        command = [arguments.launcher, "--oversubscribe", "-np", str(n_ranks)] + command
    for setting in settings + ["Output/Directory=run"]:
        command += ["--set", setting]
    done = subprocess.run(command, cwd=arguments.work, env=ENVIRONMENT, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    text = done.stdout.decode(errors="replace")
    if done.returncode != 0:
        sys.exit(f"FAILED ({done.returncode}): {' '.join(command)}\n{text}")
    return text


def peak(arguments, scene, settings, n_ranks):
    """Median of three runs, MB: free pieces between arrays are others in each."""
    peaks = []
    for _ in range(3):
        emmy(arguments, scene, settings, n_ranks, ["--overwrite"])
        with open(os.path.join(arguments.work, "run", "timing.json")) as file:
            peaks.append(json.load(file)["peak_memory_bytes"] / 1e6)
    return statistics.median(peaks)


def row(arguments, name, scene, settings, steps, n_ranks):
    """Prints a line of the table; what is wrong with it."""
    settings = settings + [f"Time/Maximum steps={steps}", "Output/Pictures=false"]
    text = emmy(arguments, scene, settings, n_ranks, ["--check"])
    told = re.search(r"^  memory of a run +([0-9]+) MB", text, re.MULTILINE)
    particles = re.search(r"^  particles +([0-9]+),", text, re.MULTILINE)
    if not told or not particles:
        sys.exit(f"FAILED: {name}: --check does not say what memory a run needs\n{text}")
    measured, predicted = peak(arguments, scene, settings, n_ranks), float(told.group(1))
    of_program = n_ranks * arguments.of_program
    ratio = predicted / measured
    above = (predicted - of_program) / (measured - of_program)
    is_large = measured > 1.5 * of_program
    print(f"| {name} | {particles.group(1)} | {n_ranks} | {predicted:.0f} | {measured:.0f} "
          f"| {ratio:.2f} | {f'{above:.2f}' if is_large else ''} |", flush=True)
    if abs(ratio - 1.) > 0.1 or (is_large and abs(above - 1.) > 0.12):
        return [f"{name}, {particles.group(1)} particles"]
    return []


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("emmy")
    parser.add_argument("root")
    parser.add_argument("launcher")
    parser.add_argument("--all", action="store_true")
    arguments = parser.parse_args()
    wrong = []
    with tempfile.TemporaryDirectory() as arguments.work:
        arguments.of_program = peak(
            arguments, BEAM, LINEAR + cells(8, 6, 6) + ["Time/Maximum steps=1"], 1)
        print(f"the program: {arguments.of_program:.0f} MB\n"
              "| scene | particles | ranks | predicted, MB | measured, MB | ratio | above the program |\n"
              "|---|---|---|---|---|---|---|")
        for scene in TEST + (MORE if arguments.all else []):
            wrong += row(arguments, *scene)
    if wrong:
        sys.exit("FAILED: further off: " + "; ".join(wrong))


main()
