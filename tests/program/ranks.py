#!/usr/bin/env python3
"""The same scenes on other numbers of ranks, which hand cells and particles to
each other before each step: the ledgers are those of one rank to 1e-10.

  ranks.py EMMY SOURCE_ROOT MPI_LAUNCHER [--ranks 2,3,4,8] [--scene NAME]...
"""
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
from kills import ENVIRONMENT, differences_of_ledgers  # noqa: E402

PLAIN = ["Output/Pictures=false", "Output/Frames=0"]
COARSE_DISCS = ["Bodies/left/Points per direction=6", "Bodies/right/Points per direction=6"]
# stages: a scene and what is set; a stage starts from the one before
SCENES = {
    "7.2": [("paper/7.2.prm", [])],
    # later the paper's method makes singular matrices of it, which blow up round-off
    "7.3b": [("paper/7.3b.prm", ["Time/Maximum steps=60"])],
    "7.4": [("paper/7.4.prm", ["Time/Maximum steps=8"])],
    "cantilever": [("benchmarks/cantilever-3d.prm", [])],
    # swings under a force at a corner; then falls, without it
    "chain": [("examples/point-load.prm", ["Time/End time=0.6", "Checkpoint/Every steps=1000"]),
              ("examples/point-load.prm", ["Effects/Names=gravity",
                                           "Effects/Gravity/Acceleration=1, -9.81",
                                           "Boundary conditions/Fixed=",
                                           "Boundary conditions/Roller=y-min",
                                           "Time/End time=0.4"])],
    # starved nodes, the geometry of the middle, and files of all kinds
    "discs": [("paper/7.2.prm", COARSE_DISCS + [
        "Grid/Cells=40, 24", "Method/Shape functions=GIMP", "Method/Geometry=middle",
        "Method/Starved nodes=follow", "Time/Step rule=normalised", "Time/Factor=2",
        "Output/Frames=5", "Output/Pictures=true"])],
    # tools with friction
    "roll": [("examples/roll.prm", ["Time/Maximum steps=40"])],
    # a wall that moves
    "shaken": [("examples/shaken-block.prm", ["Time/Maximum steps=60"])],
}
SHORT = {  # in some seconds
    "7.2": ["Time/Maximum steps=12"] + COARSE_DISCS,
    "7.3b": ["Time/Maximum steps=6", "Bodies/left/Points per direction=4",
             "Bodies/right/Points per direction=4"],
    "7.4": ["Time/Maximum steps=2", "Grid/Cells=6, 25, 6"],
    "cantilever": ["Time/Maximum steps=2", "Grid/Cells=12, 9, 9"],
    "chain": [], "discs": ["Time/Maximum steps=25"], "roll": [], "shaken": [],
}


def run(arguments, work, name, n_ranks):
    """Ledgers of the stages; and words on what was handed over."""
    ledgers, loads = [], []
    for i, (scene, settings) in enumerate(SCENES[name]):
        folder = f"{name}-{n_ranks}-{i}"
        settings = PLAIN + settings + (SHORT[name] if arguments.short else []) + [
            "Ranks/Rebalance above=0", f"Output/Directory={folder}"]
        if i > 0:
            settings.append(f"Start/From={name}-{n_ranks}-{i - 1}")
        command = [os.path.abspath(arguments.emmy),
                   os.path.join(os.path.abspath(arguments.root), "prm", scene)]
        for setting in settings:
            command += ["--set", setting]
        if n_ranks > 1:
            command = [arguments.launcher, "--oversubscribe", "--bind-to", "none", "-np",
                       str(n_ranks)] + command
        done = subprocess.run(command, cwd=work, env=ENVIRONMENT, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=3000)
        if done.returncode != 0:
            sys.exit(f"FAILED: {' '.join(command)}\n{done.stdout.decode(errors='replace')}")
        with open(os.path.join(work, folder, "ledger.csv"), "rb") as file:
            ledgers.append(file.read())
        with open(os.path.join(work, folder, "timing.json")) as file:
            timing = json.load(file)
        if n_ranks > 1 and timing["rebalancings"] != timing["steps"]:
            sys.exit(f"FAILED: {name} on {n_ranks} ranks: not each step handed over")
        with open(os.path.join(work, folder, "run.log")) as file:
            loads += re.findall(r"busiest had (\S+) of the mean work, and has (\S+);", file.read())
    return ledgers, sum(before != after for before, after in loads)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("emmy")
    parser.add_argument("root")
    parser.add_argument("launcher")
    parser.add_argument("--ranks", default="2,3,4,8")
    parser.add_argument("--scene", action="append")
    parser.add_argument("--short", action="store_true")
    arguments = parser.parse_args()
    n_moved, failed = 0, False
    with tempfile.TemporaryDirectory() as work:
        for name in arguments.scene or SCENES:
            one, _ = run(arguments, work, name, 1)
            for n_ranks in map(int, arguments.ranks.split(",")):
                several, moved = run(arguments, work, name, n_ranks)
                n_moved += moved
                found = [differences_of_ledgers(a, b) for a, b in zip(one, several)]
                problems = [problem for part in found for problem in part[0]]
                rows = sum(ledger.count(b"\n") - 2 for ledger in several)
                print(f"{name} on {n_ranks} ranks: {rows} steps, {moved} with another load after; "
                      f"largest difference {max(worst for _, worst in found):.2g}"
                      + "".join("\n  FAILED: " + problem for problem in problems), flush=True)
                failed = failed or bool(problems)
    if n_moved == 0:
        sys.exit("FAILED: nothing moved between ranks, which tests nothing")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
