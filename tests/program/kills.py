#!/usr/bin/env python3
"""Kill a run with SIGKILL again and again, go on each time, and compare with the
run that nobody killed: the ledger, to the last bit on the same number of ranks
and to 1e-10 where it changes; particle and grid files, series and snapshots, to
the last bit.

  kills.py EMMY SOURCE_ROOT MPI_LAUNCHER [--kills 20] [--seed N]
           [--scene NAME]... [--ranks 2] [--ranks 1,2,3]
"""
import argparse
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

SCENES = {
    # elastic collision with GIMP, with the geometry of the middle, and starved nodes
    "7.2": ("paper/7.2.prm", ["Method/Shape functions=GIMP", "Method/Geometry=middle",
                              "Method/Starved nodes=follow", "Bodies/left/Points per direction=10",
                              "Bodies/right/Points per direction=10", "Time/Maximum steps=80",
                              "Output/Frames=20"]),
    # plastic collision; with free nodes matrices are nearly singular, and which steps are
    # halved depends on round-off, so on the number of ranks
    "7.3b": ("paper/7.3b.prm", ["Method/Starved nodes=follow", "Method/Geometry=middle",
                                "Time/Maximum steps=80", "Bodies/left/Points per direction=4",
                                "Bodies/right/Points per direction=4", "Output/Frames=20"]),
    # in three dimensions
    "3d": ("validation/two-balls.prm", ["Time/Maximum steps=25", "Output/Frames=10"]),
    # a block that flies through a large grid, whose window follows, while ranks hand
    # over cells; in some seconds
    "flight": ("examples/shaken-block.prm", ["Grid/Upper corner=40, 40", "Grid/Cells=160, 160",
                                             "Boundary conditions/Fixed=",
                                             "Boundary conditions/Velocity of y-min=",
                                             "Bodies/block/box/Lower corner=2, 2",
                                             "Bodies/block/box/Upper corner=3, 3.5",
                                             "Bodies/block/Initial velocity=18 + y; 12 - x",
                                             "Ranks/Rebalance above=1.02",
                                             "Time/Maximum steps=60", "Output/Frames=40"]),
    # bodies that touch and rub, in some seconds
    "contact": ("examples/two-discs.prm", ["Effects/Contact/Friction coefficient=0.4",
                                           "Time/Maximum steps=90", "Output/Frames=10"]),
    # a wall that moves, in some seconds
    "short": ("examples/shaken-block.prm", ["Time/Maximum steps=40", "Output/Frames=10"]),
}
OWN = {"run.log", "timing.json", "parameters.prm", "report.html"}  # of each session
ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS="1", DEAL_II_NUM_THREADS="1",
                   OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_mpi_yield_when_idle="1")


def descendants(pid):
    """All processes below one, by their parents in /proc."""
    children = {}
    for name in os.listdir("/proc"):
        if name.isdigit():
            try:
                with open(f"/proc/{name}/stat") as file:
                    parent = int(file.read().rsplit(")", 1)[1].split()[1])
            except (OSError, IndexError):
                continue
            children.setdefault(parent, []).append(int(name))
    found, todo = [], [pid]
    while todo:
        below = children.get(todo.pop(), [])
        found += below
        todo += below
    return found


def is_alive(pid):
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def n_rows(ledger):
    """Whole rows of steps, that of the start too."""
    try:
        with open(ledger, "rb") as file:
            return max(0, file.read().count(b"\n") - 1)
    except OSError:
        return 0


def kill_all(process):
    """It and all below it, at once; back when they are gone."""
    all_of_them = descendants(process.pid) + [process.pid]
    for pid in all_of_them:
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
    process.wait()
    while any(is_alive(pid) for pid in all_of_them):
        time.sleep(0.01)


class Runner:
    def __init__(self, arguments, work):
        self.emmy = os.path.abspath(arguments.emmy)
        self.launcher, self.work = arguments.launcher, work

    def start(self, n_ranks, words):
        command = [self.emmy] + words
        if n_ranks > 1:
            command = [self.launcher, "--oversubscribe", "--bind-to", "none", "-np",
                       str(n_ranks)] + command
        self.out = open(os.path.join(self.work, "out"), "w")
        return subprocess.Popen(command, cwd=self.work, env=ENVIRONMENT, stdout=self.out,
                                stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)

    def said(self):
        with open(os.path.join(self.work, "out"), errors="replace") as file:
            return file.read()

    def finish(self, n_ranks, words):
        """Seconds that it took."""
        begin = time.monotonic()
        if self.start(n_ranks, words).wait(timeout=1200) != 0:
            sys.exit(f"FAILED: emmy {' '.join(words)}\n{self.said()}")
        return time.monotonic() - begin

    def kill_at(self, n_ranks, words, ledger, row, seconds):
        """Some seconds after the ledger has a row, or, with no row, after the start.
        Whether it was killed; else it ended by itself, well."""
        process = self.start(n_ranks, words)
        latest = time.monotonic() + 1200
        while process.poll() is None and row is not None and n_rows(ledger) <= row:
            if time.monotonic() > latest:
                kill_all(process)
                sys.exit(f"FAILED: hangs: emmy {' '.join(words)}\n{self.said()}")
            time.sleep(0.01)
        try:
            if process.wait(timeout=seconds) != 0:
                sys.exit(f"FAILED: emmy {' '.join(words)}\n{self.said()}")
            return False
        except subprocess.TimeoutExpired:
            pass
        kill_all(process)
        return True


def files_in(folder):
    result = {}
    for path, folders, names in os.walk(folder):
        if "checkpoints" in folders:
            folders.remove("checkpoints")
        for name in names:
            full = os.path.join(path, name)
            with open(full, "rb") as file:
                # deal.II writes the time of day into a comment
                result[os.path.relpath(full, folder)] = re.sub(
                    rb"<!--.*?-->", b"", file.read(), flags=re.DOTALL)
    return result


def rows_of(text):
    lines = text.decode().splitlines()
    return lines[0].split(","), [[float(x) for x in line.split(",")] for line in lines[1:]]


def differences_of_ledgers(one, two):
    """In words; and the largest relative one."""
    if not two.endswith(b"\n"):
        return ["the ledger's last line is cut"], 0.
    (columns, one), (columns_2, two) = rows_of(one), rows_of(two)
    if columns != columns_2 or [row[0] for row in one] != [row[0] for row in two]:
        return ["other columns or steps"], 0.
    energy = max(row[3] for row in one)
    worst, where = 0., ""
    for c, name in enumerate(columns):
        if "iterations" in name:
            continue
        scale = max(abs(row[c]) for row in one)
        scale = max(scale, energy if any(word in name for word in (
            "energy", "work", "loss", "error", "momentum", "dissipation")) else 1.)
        for a, b in zip(one, two):
            if not abs(a[c] - b[c]) <= worst * scale:
                worst, where = abs(a[c] - b[c]) / scale, f"{name} of step {a[0]:.0f}"
    return ([] if worst <= 1e-10 else [f"the ledger differs by {worst:.2g}: {where}"]), worst


def differences(reference, other, is_exact):
    """In words; and the largest relative one of the ledger."""
    ours, theirs = files_in(reference), files_in(other)
    ledger = ours["ledger.csv"], theirs["ledger.csv"]
    if is_exact:
        problems = [f"{name} differs" for name in sorted(set(ours) & set(theirs) - OWN)
                    if ours[name] != theirs[name]]
        problems += [f"{name} is in one folder only" for name in sorted(set(ours) ^ set(theirs))]
        return problems, 0.
    problems, worst = differences_of_ledgers(*ledger)
    series = sorted(name for name in ours if name.endswith(".pvd"))
    problems += [f"{name} differs" for name in series if ours[name] != theirs.get(name)]
    return problems, worst


def steps_by_ranks(run, n_last):
    """How many rows of the ledger come from sessions on each number of ranks."""
    with open(os.path.join(run, "run.log")) as file:
        log = file.read()
    begins = [(0, int(re.search(r"^  ranks +(\d+)$", log, re.MULTILINE).group(1)))] + [
        (int(step), int(n)) for step, n in
        re.findall(r"^continued from step (\d+), .* s, on (\d+) ranks? ", log, re.MULTILINE)]
    with open(os.path.join(run, "ledger.csv")) as file:
        begins.append((len(file.readlines()) - 2, n_last))
    result = {}
    for (step, n), (end, _) in zip(begins, begins[1:]):
        result[n] = result.get(n, 0) + end - step
    return result


def check(arguments, runner, name, ranks, generator):
    scene, settings = SCENES[name]
    words = [os.path.join(arguments.root, "prm", scene)]
    for setting in settings + ["Output/Pictures=true", "Output/Directory=run"]:
        words += ["--set", setting]
    reference, run = (os.path.join(runner.work, folder) for folder in ("reference", "run"))
    shutil.rmtree(reference, ignore_errors=True)
    shutil.rmtree(run, ignore_errors=True)
    seconds = runner.finish(ranks[0], words)
    to_start = {n: runner.finish(n, words + ["--overwrite", "--set", "Time/Maximum steps=1"])
                for n in sorted(set(ranks))}
    runner.finish(ranks[0], words + ["--overwrite"])
    os.rename(run, reference)
    with open(os.path.join(reference, "ledger.csv")) as file:
        n_steps = len(file.readlines()) - 2
    of_a_step = max(seconds - to_start[ranks[0]], 0.2) / n_steps
    ledger = os.path.join(run, "ledger.csv")

    n_killed, n_runs, worst, cut, anew, steps = 0, 0, 0., 0, 0, {}
    # until there were so many, and each number of ranks has made steps
    while n_killed < arguments.kills or (n_runs < 8 and any(steps.get(n, 0) == 0 for n in ranks)):
        shutil.rmtree(run, ignore_errors=True)
        # after these rows, so that sessions make steps however fast the machine is
        rows = range(2, n_steps - 1, 3)
        rows = sorted(generator.sample(rows, min(len(rows), max(arguments.kills - n_killed,
                                                                len(set(ranks))))))
        if not rows:
            sys.exit(f"FAILED: {name} has only {n_steps} steps, too few to be killed between")
        session, is_first = 0, True
        while True:
            n_ranks = ranks[session % len(ranks)]
            checkpoints = os.path.join(run, "checkpoints")
            is_there = os.path.isdir(checkpoints) and any(
                folder[-1].isdigit() for folder in os.listdir(checkpoints))
            anew += not is_first and not is_there
            is_first = False
            command = ["--restart", "run"] if is_there else words + [
                "--overwrite", "--set", "Checkpoint/Every steps=1"]
            if session == len(rows):
                runner.finish(n_ranks, command)
                break
            if generator.random() < 0.25:  # also while it starts
                was_killed = runner.kill_at(n_ranks, command, ledger, None,
                                            to_start[n_ranks] * generator.random())
            else:
                was_killed = runner.kill_at(n_ranks, command, ledger, max(rows[session], n_rows(ledger)),
                                            of_a_step * n_ranks * generator.uniform(0, 2))
                session += 1
            if not was_killed:
                break
            n_killed += 1
            if os.path.isfile(ledger):
                with open(ledger, "rb") as file:
                    text = file.read()
                cut += len(text) > 0 and not text.endswith(b"\n")
        n_runs += 1
        for n, made in steps_by_ranks(run, n_ranks).items():
            steps[n] = steps.get(n, 0) + made
        is_exact = len(set(ranks)) == 1
        problems, difference = differences(reference, run, is_exact)
        worst = max(worst, difference)
        if problems:
            sys.exit(f"FAILED: {name} on {ranks} ranks after {n_killed} kills:\n  " +
                     "\n  ".join(problems))
    print(f"{name} on {'-'.join(map(str, ranks))} ranks: killed {n_killed} times in {n_runs} runs "
          f"(begun anew {anew} times, half lines {cut}); "
          + ("all files the same" if is_exact else f"ledger within {worst:.2g}")
          + "; steps that remain of sessions on "
          + ", ".join(f"{n}: {steps.get(n, 0)}" for n in sorted(set(ranks))), flush=True)
    if any(steps.get(n, 0) == 0 for n in ranks):
        sys.exit(f"FAILED: {name}: no steps were made on some of {ranks} ranks, which tests nothing")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("emmy")
    parser.add_argument("root")
    parser.add_argument("launcher")
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=random.randrange(10**6))
    parser.add_argument("--scene", action="append")
    parser.add_argument("--ranks", action="append")
    arguments = parser.parse_args()
    arguments.root = os.path.abspath(arguments.root)
    print(f"seed {arguments.seed}", flush=True)
    generator = random.Random(arguments.seed)
    for name in arguments.scene or ["7.2", "7.3b", "3d"]:
        for ranks in arguments.ranks or ["2", "1,2,3"]:
            with tempfile.TemporaryDirectory() as work:
                check(arguments, Runner(arguments, work), name,
                      [int(n) for n in ranks.split(",")], generator)


if __name__ == "__main__":
    main()
