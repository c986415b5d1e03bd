#!/usr/bin/env python3
"""What more ranks bring and cost, for the beam in space of prm/benchmarks. For
doc/scaling.md; speed needs an idle machine, the others do not.

  ranks.py speed    EMMY SOURCE_ROOT MPI_LAUNCHER [--ranks 1,2] [--times 5] [--cells 52]...
      seconds of the steps, phase by phase: medians of runs that alternate; and how
      much faster they could be at most: as many runs of one rank beside one another
  ranks.py memory   EMMY SOURCE_ROOT MPI_LAUNCHER [--ranks 1,2,4] [--cells 52]...
      largest memory of a rank, with and without what a rank without particles has
  ranks.py messages EMMY SOURCE_ROOT MPI_LAUNCHER [--ranks 2,4,8] [--cells 32]...
      what a rank sends in a step; needs the target count_messages
  ranks.py work     EMMY SOURCE_ROOT MPI_LAUNCHER [--times 3] [--cells 32]...
      how many particles a cell counts for (grid/cell_work.h), from 2 and 3 particles
      per direction: seconds of the processor, the least of some runs on one rank
"""
import argparse
import concurrent.futures
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile

ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS="1", DEAL_II_NUM_THREADS="1",
                   OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
# once in a run, whatever its steps
ONCE = {"setup", "scene card", "output", "pictures"}


def run(arguments, n_ranks, cells, steps, settings=(), environment=None, core=None):
    """timing.json of a run; on a core, if one is named, without the launcher."""
    folder = "run" if core is None else f"run-{core}"
    grid = ", ".join(str(n) for n in (cells, cells * 3 // 4, cells * 3 // 4))
    command = [os.path.abspath(arguments.emmy), os.path.join(
        os.path.abspath(arguments.root), "prm/benchmarks/cantilever-3d.prm"), "--overwrite"]
    for setting in [f"Grid/Cells={grid}", f"Time/Maximum steps={steps}", "Output/Frames=0",
                    f"Output/Directory={folder}", f"Time/Factor={arguments.factor}",
                    f"Method/Shape functions={arguments.functions}",
                    f"Method/Geometry={arguments.geometry}", *settings]:
        command += ["--set", setting]
    words = []
    for name, value in (environment or {}).items():
        words += ["-x", f"{name}={value}"]
    # one rank is bound to a core too, as each of several
    bind = "core" if n_ranks <= len(os.sched_getaffinity(0)) else "none"
    command = ([arguments.launcher, "--oversubscribe", "--bind-to", bind, "-np", str(n_ranks)] + words
               if core is None else ["taskset", "-c", str(core)]) + command
    done = subprocess.run(command, cwd=arguments.work, env=ENVIRONMENT, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode != 0:
        sys.exit(f"FAILED: {' '.join(command)}\n{done.stdout.decode(errors='replace')}")
    with open(os.path.join(arguments.work, folder, "timing.json")) as file:
        return json.load(file)


def steps_of(timing):
    """Seconds of whole steps."""
    return timing["total_seconds"] - sum(p["mean_seconds"] for p in timing["phases"] if p["name"] in ONCE)


def at_most(arguments, n, cells, steps):
    """What n ranks could gain: n runs that know nothing of each other take their cores'
    common memory and power as ranks would, and longer than one alone."""
    cores = sorted(os.sched_getaffinity(0))[:n]
    alone = statistics.mean(steps_of(run(arguments, 1, cells, steps, core=core)) for core in cores)
    with concurrent.futures.ThreadPoolExecutor(n) as pool:
        beside = statistics.mean(pool.map(
            lambda core: steps_of(run(arguments, 1, cells, steps, core=core)), cores))
    return n * alone / beside


def points_of(timing):
    """Particles, from the points that a phase counted in all steps."""
    for phase in timing["phases"]:
        if phase["name"] == "grid to particles":
            return phase["points"] // timing["steps"]
    return 0


def speed(arguments, cells):
    ranks = arguments.ranks or [1, 2]
    steps = arguments.steps or (2 if cells > 80 else 5)
    found = {n: [] for n in ranks}
    bounds = []
    for _ in range(arguments.times):
        for n in ranks:
            found[n].append(run(arguments, n, cells, steps))
        if 1 < ranks[-1] <= len(os.sched_getaffinity(0)):
            bounds.append(at_most(arguments, ranks[-1], cells, steps))
    first = ranks[0]
    print(f"\n{points_of(found[first][0])} particles, {arguments.functions}, {arguments.geometry}, "
          f"step of {arguments.factor} cells; {steps} steps, median of {arguments.times}: seconds "
          "of the slowest rank")
    print(f"{'phase':26}" + "".join(f"{n:>4} ranks" for n in ranks) + "    gain")

    def line(name, seconds_of):
        medians = [statistics.median(seconds_of(timing) for timing in found[n]) for n in ranks]
        print(f"{name:26}" + "".join(f"{seconds:10.3f}" for seconds in medians)
              + (f"{medians[0] / medians[-1]:8.2f}" if medians[-1] > 0 else ""), flush=True)

    def seconds(name):
        return lambda timing: sum(p["seconds"] for p in timing["phases"] if p["name"] == name)

    names = []
    for n in ranks:
        names += [p["name"] for p in found[n][0]["phases"] if p["name"] not in names]
    for name in names:
        line(name, seconds(name))
    line("outside", lambda timing: timing["seconds_outside_phases"])
    line("whole steps", steps_of)
    if bounds:
        print(f"{'at most, on this machine':26}" + " " * 10 * len(ranks) + f"{statistics.median(bounds):8.2f}")
    line("whole run", lambda timing: timing["total_seconds"])
    for name in ("newton_iterations", "linear_iterations"):
        print(f"{name.replace('_', ' '):26}" + "".join(f"{found[n][0][name]:>10}" for n in ranks)
              + f"    times {found[ranks[-1]][0][name] / max(1, found[first][0][name]):.2f}")


def memory(arguments, cells):
    ranks = arguments.ranks or [1, 2, 4]
    print(f"\nMB of the rank with most, {cells} cells along the beam; constant: that of a rank "
          "of the same beam in 8 cells")
    print(f"{'ranks':>6}{'particles':>11}{'a rank':>9}{'constant':>10}{'rest':>9}"
          f"{'rest x ranks':>14}{'to one rank':>13}")
    one = None
    for n in ranks:
        empty = run(arguments, n, 8, 2)["peak_memory_bytes_of_a_rank"] / 1e6
        timing = run(arguments, n, cells, arguments.steps or 2)
        full = timing["peak_memory_bytes_of_a_rank"] / 1e6
        one = one or n * (full - empty)
        print(f"{n:6}{points_of(timing):11}{full:9.0f}{empty:10.0f}{full - empty:9.0f}"
              f"{n * (full - empty):14.0f}{n * (full - empty) / one:13.2f}", flush=True)


def messages(arguments, cells):
    library = os.path.join(os.path.dirname(os.path.abspath(arguments.emmy)),
                           "tests/libcount_messages.so")
    if not os.path.isfile(library):
        sys.exit(f"no {library}: build the target count_messages")
    few, many = 3, 9
    for rebalance in ("1.2", "0"):
        print(f"\n{cells} cells along the beam, "
              + ("cells handed over before each step" if rebalance == "0" else "nothing handed over")
              + "; of a rank in a step (between steps "
              f"{few + 1} and {many}): number, kB")
        for n in arguments.ranks or [2, 4, 8]:
            sums, iterations = [], []
            for steps in (few, many):
                name = os.path.join(arguments.work, "messages")
                timing = run(arguments, n, cells, steps, [f"Ranks/Rebalance above={rebalance}"],
                             {"LD_PRELOAD": library, "EMMY_MESSAGES": name})
                iterations.append((timing["newton_iterations"], timing["linear_iterations"]))
                with open(name) as file:
                    sums.append([line.split() for line in file])
            parts = []
            for before, after in zip(*sums):
                number, size = ((float(after[i]) - float(before[i])) / (many - few) for i in (1, 2))
                parts.append(f"{before[0].replace('_', ' ')} {number:.0f}, {size / 1e3:.1f}")
            newton, linear = ((b - a) / (many - few) for a, b in zip(*iterations))
            print(f"  {n} ranks: {'; '.join(parts)} ({newton:.1f} Newton, {linear:.1f} linear "
                  "iterations)", flush=True)


def work(arguments, cells):
    few, many = 2, 6
    pairs = []  # particles, active cells, seconds
    for per_direction in (2, 3):
        seconds = {few: [], many: []}
        for _ in range(arguments.times):
            for steps in (few, many):
                before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
                timing = run(arguments, 1, cells, steps,
                             [f"Bodies/beam/Points per direction={per_direction}"])
                seconds[steps].append(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before)
        with open(os.path.join(arguments.work, "run", "ledger.csv")) as file:
            lines = file.read().splitlines()
        row = dict(zip(lines[0].split(","), lines[-1].split(",")))
        pairs.append((float(row["particles"]), float(row["active_cells"]),
                      (min(seconds[many]) - min(seconds[few])) / (many - few)))
    (n, c, t), (n_2, c_2, t_2) = pairs
    of_point = (t * c_2 - t_2 * c) / (n * c_2 - n_2 * c)
    of_cell = (t - of_point * n) / c
    print(f"{cells} cells along the beam, {arguments.functions}, {arguments.geometry}: a step takes "
          f"{1e6 * of_point:.1f} us of a particle and {1e6 * of_cell:.0f} us of an active cell, "
          f"as much as {of_cell / of_point:.0f} particles ({n:.0f} and {n_2:.0f} in {c:.0f} and "
          f"{c_2:.0f} cells)", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("what", choices=["speed", "memory", "messages", "work"])
    parser.add_argument("emmy")
    parser.add_argument("root")
    parser.add_argument("launcher")
    parser.add_argument("--ranks", type=lambda text: [int(n) for n in text.split(",")])
    parser.add_argument("--cells", type=int, action="append")
    parser.add_argument("--steps", type=int)
    parser.add_argument("--times", type=int, default=5)
    parser.add_argument("--factor", default="15")
    parser.add_argument("--functions", default="linear")
    parser.add_argument("--geometry", default="start")
    arguments = parser.parse_args()
    usual = {"speed": [52, 96], "memory": [52], "messages": [32], "work": [32]}[arguments.what]
    with tempfile.TemporaryDirectory() as arguments.work:
        for cells in arguments.cells or usual:
            {"speed": speed, "memory": memory, "messages": messages, "work": work}[
                arguments.what](arguments, cells)


main()
