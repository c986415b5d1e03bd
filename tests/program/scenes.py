#!/usr/bin/env python3
"""Every parameter file in the tree is read, and does a step.

    scenes.py SOURCE_ROOT EMMY

Scenes make one step, with everything that they write: they complain of nothing,
the ledger has the start and the step, the bytes of the scene card add up, and the
parameters that the run leaves are read back unchanged (of the folders that show
what emmy can do). Scenes that take too long for that are only read and built, and
studies are only read. A file that is not for the program is said to be so here.
"""
import os
import re
import subprocess
import sys
import tempfile
import time

ONLY_CHECKED = {  # why no step is made
    "prm/benchmarks/cantilever-3d.prm": "size: a step takes half a minute",
    "prm/benchmarks/taylor-bar.prm": "size",
    "prm/validation/taylor-6.prm": "size",
    "prm/validation/taylor-8.prm": "size",
}
NOT_RUN = {
    "doc/parameters.prm": "the reference of all parameters; the test parameter_reference makes it",
    "doc/study.prm": "the same of studies",
    "doc/tutorials/step-3/step-3.prm": "its material is not emmy's; the test tutorials runs it",
    "doc/tutorials/step-4/step-4.prm": "its effect is not emmy's; the same",
    "doc/tutorials/step-5/step-5.prm": "its measurement is not emmy's; the same",
}


def scenes(root):
    for top in ["prm", "doc"]:
        for folder, _, files in os.walk(os.path.join(root, top)):
            for name in sorted(files):
                if name.endswith(".prm"):
                    yield os.path.relpath(os.path.join(folder, name), root)


READ_BACK = ("prm/examples/", "prm/ground/", "prm/paper/")


def wrong_card(card):
    """Whether bytes of what is present add up to those of <all>."""
    sizes = {}
    is_present = False
    for line in card.splitlines():
        if line.startswith("  present") or not line.startswith("    "):
            is_present = line.startswith("  present")
        elif is_present and line[4] != " ":
            sizes[line[4:26].rstrip()] = int(line[26:].split()[0])
    total = sizes.pop("all", -1)
    return total != sum(sizes.values()) or len(sizes) < 3


def wrong_with(run, errors):
    """What a run of one step left that it should not, in words; or nothing."""
    if errors:
        return "it complains: " + errors
    with open(os.path.join(run, "ledger.csv"), encoding="utf-8") as file:
        if sum(1 for _ in file) != 3:
            return "its ledger does not have three lines"
    with open(os.path.join(run, "run.log"), encoding="utf-8") as file:
        if wrong_card(file.read()):
            return "the bytes of its card do not add up"
    return ""


def is_read_back(run, emmy, environment):
    """Whether the parameters that the run leaves are printed as they are."""
    name = os.path.join(run, "parameters.prm")
    printed = subprocess.run([emmy, "--print-parameters", name], cwd=os.path.dirname(run), env=environment,
                             capture_output=True, text=True, timeout=300)
    with open(name, encoding="utf-8") as file:
        return file.read() == printed.stdout


def main():
    root, emmy = map(os.path.abspath, sys.argv[1:3])
    environment = dict(os.environ, OMPI_MCA_ess_singleton_isolated="1", OMPI_MCA_pml="ob1", OMPI_MCA_btl="self")
    n_steps = n_checked = 0
    failures = []
    with tempfile.TemporaryDirectory() as folder:
        for link in ["prm", "doc"]: # some name files relative to the root
            os.symlink(os.path.join(root, link), os.path.join(folder, link))
        for scene in sorted(scenes(root)):
            if scene in NOT_RUN:
                continue
            with open(os.path.join(root, scene), encoding="utf-8") as file:
                is_study = re.search(r"^subsection Study", file.read(), re.M)
            if is_study:
                command = ["study", "--check", scene]
            elif scene in ONLY_CHECKED:
                command = ["--check", "--all", scene]
            else:
                command = [scene, "--all", "--set", "Time/Maximum steps=1", "--set", "Output/Directory=run", "--overwrite",
                           "--set", "Output/Pictures=false"]
            start = time.monotonic()
            done = subprocess.run([emmy, *command], cwd=folder, env=environment, capture_output=True, text=True,
                                  stdin=subprocess.DEVNULL, timeout=300)
            seconds = time.monotonic() - start
            if "-v" in sys.argv:
                print(f"{seconds:6.2f} s  {scene}", flush=True)
            n_steps += command[0] == scene
            n_checked += command[0] != scene
            problem = done.stderr[-1500:] if done.returncode else ""
            if scene in ONLY_CHECKED and not problem and wrong_card(done.stdout):
                problem = "the bytes of its card do not add up"
            if command[0] == scene and not problem:
                run = os.path.join(folder, "run")
                problem = wrong_with(run, done.stderr)
                if not problem and scene.startswith(READ_BACK) and not is_read_back(run, emmy, environment):
                    problem = "its parameters.prm is not read back unchanged"
            if problem:
                failures.append(scene)
                print(f"FAILED: {scene}\n{problem}", flush=True)
    for scene in [*NOT_RUN, *ONLY_CHECKED]:
        if not os.path.exists(os.path.join(root, scene)):
            failures.append(scene)
            print(f"FAILED: there is no <{scene}>; remove it from the list in scenes.py")
    print(f"{n_steps} scenes made a step, {n_checked} files were read, {len(failures)} failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
