#!/usr/bin/env python3
"""What a restart takes and what it refuses, on the command line: signals,
damaged checkpoints, other scenes, folders that cannot be written, chains of runs,
failed steps. Each check has a name.

  restart.py EMMY SOURCE_ROOT MPI_LAUNCHER [PART]... [any_byte=N]

any_byte, which takes minutes, flips one bit of the newest checkpoint N times.
"""
import os
import random
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

EMMY, ROOT, LAUNCHER = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), sys.argv[3]
ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS="1", DEAL_II_NUM_THREADS="1",
                   OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_mpi_yield_when_idle="1", OMPI_MCA_odls_base_sigkill_timeout="0")
counts = {"checks": 0, "failed": 0, "skipped": 0}
last = {"status": 0, "text": "", "words": []}

BLOCK = """
set Dimension = 2
subsection Grid
  set Lower corner = 0, 0
  set Upper corner = 4, 4
  set Cells        = 8, 8
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
    set Points per direction = 2
    subsection box
      set Lower corner = 1, 0
      set Upper corner = 2, 1
    end
  end
end
subsection Boundary conditions
  set Fixed = y-min
end
subsection Effects
  set Names = gravity
  subsection Gravity
    set Acceleration = 3, -9.81
  end
end
subsection Measurements
  set Names = corner
  subsection corner
    set Type       = particle
    set Nearest to = 2, 1
  end
end
subsection Time
  set End time  = 1
  set Step rule = fixed
  set Step size = 0.02
end
subsection Output
  set Directory = run
  set Frames    = 5
  set Pictures  = false
end
subsection Checkpoint
  set Every steps = 5
end
"""


def check(fact, name):
    counts["checks"] += 1
    if not fact:
        counts["failed"] += 1
        print(f"FAILED: {name}\n  emmy {' '.join(last['words'])}: {last['status']}")
        print("\n".join("  " + line for line in last["text"].splitlines()[-12:]), flush=True)


def sets(settings):
    return [word for setting in settings for word in ("--set", setting)]


def emmy(*words, ranks=1, timeout=120):
    """Runs; returns the exit code, None if it hangs."""
    command = [EMMY] + list(words)
    if ranks > 1:
        command = [LAUNCHER, "--oversubscribe", "--bind-to", "none", "-np", str(ranks)] + command
    last["words"] = list(words) + ([f"({ranks} ranks)"] if ranks > 1 else [])
    try:
        done = subprocess.run(command, env=ENVIRONMENT, stdin=subprocess.DEVNULL, timeout=timeout,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        last["status"], last["text"] = done.returncode, done.stdout.decode(errors="replace")
    except subprocess.TimeoutExpired as stopped:
        last["status"], last["text"] = None, (stopped.stdout or b"").decode(errors="replace") + "\nHANGS"
    return last["status"]


def says(words):
    return " ".join(words.split()) in " ".join(last["text"].split())


def content(name):
    with open(name, "rb") as file:
        return file.read()


def state_of(folder):
    return {os.path.join(path, name): content(os.path.join(path, name))
            for path, _, names in os.walk(folder) for name in names}


def rows(folder):
    lines = content(folder + "/ledger.csv").decode().splitlines()
    names = lines[0].split(",")
    return [dict(zip(names, map(float, line.split(",")))) for line in lines[1:]]


def refuses(name, *words, because, ranks=1, code=1):
    """An error in words, and no file in the folder differs afterwards."""
    before = state_of("run")
    emmy(*words, ranks=ranks)
    check(last["status"] == code, f"{name}: exit code {code}")
    check(says(because), f"{name}: says <{because}>")
    check("unexpected" not in last["text"], f"{name}: nothing unexpected")
    check(state_of("run") == before, f"{name}: no file changed")


def crc64(data):
    """CRC-64 as xz has it."""
    crc = 0xFFFFFFFFFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ 0xC96C5795D7870F42 if crc & 1 else crc >> 1
    return crc ^ 0xFFFFFFFFFFFFFFFF


def seal_again(name, change):
    """Change a sealed file and give it the right checksum."""
    data = change(content(name)[:-8])
    with open(name, "wb") as file:
        file.write(data + struct.pack("<Q", crc64(data)))


def flip(name, place):
    data = bytearray(content(name))
    data[place % len(data)] ^= 4
    with open(name, "wb") as file:
        file.write(data)


def reference_and_run(steps=12):
    """The run that nobody stopped, in `reference`, and one up to a step."""
    for folder in ("run", "reference"):
        shutil.rmtree(folder, ignore_errors=True)
    emmy("block.prm", *sets(["Checkpoint/Every steps=0", "Time/Maximum steps=25"]))
    check(last["status"] == 0, "the reference runs")
    os.rename("run", "reference")
    emmy("block.prm", *sets([f"Time/Maximum steps={steps}"]))
    check(last["status"] == 0, "the first part runs")
    check(sorted(os.listdir("run/checkpoints")) == [f"step-{n:08}" for n in (10, steps)],
          "checkpoints: the last two, one of the end among them")


def goes_on(name, ranks=1, more=()):
    emmy("--restart", "run", "--set", "Time/Maximum steps=25", *more, ranks=ranks)
    check(last["status"] == 0, f"{name}: goes on")
    check(content("run/ledger.csv") == content("reference/ledger.csv"), f"{name}: the same ledger")


def signals():
    print("Signals", flush=True)
    long = sets(["Time/End time=1000", "Time/Step size=0.02", "Output/Frames=0"])
    for number, name, ranks in ((signal.SIGTERM, "SIGTERM", 1), (signal.SIGINT, "SIGINT", 1),
                                (signal.SIGUSR1, "SIGUSR1", 1), (signal.SIGUSR1, "SIGUSR1", 2)):
        shutil.rmtree("run", ignore_errors=True)
        command = [EMMY, "block.prm", *long, "--set", "Checkpoint/Every steps=0"]
        if ranks > 1:
            command = [LAUNCHER, "--oversubscribe", "--bind-to", "none", "-np", str(ranks)] + command
        last["words"] = command[1:] + [name]
        process = subprocess.Popen(command, env=ENVIRONMENT, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        for _ in range(600):
            if os.path.isfile("run/ledger.csv") and content("run/ledger.csv").count(b"\n") > 3:
                break
            time.sleep(0.05)
        process.send_signal(number)
        try:
            last["text"] = process.communicate(timeout=60)[0].decode()
        except subprocess.TimeoutExpired:
            process.kill()
            last["text"] = "HANGS"
        last["status"] = process.returncode
        what = f"{name} on {ranks}"
        check(last["status"] == 75, f"{what}: exit code 75")
        check(says(f"interrupted by {name} after step"), f"{what}: says by what")
        check(says("It goes on with: emmy --restart run"), f"{what}: says how it goes on")
        step = int(rows("run")[-1]["step"])
        check(os.listdir("run/checkpoints") == [f"step-{step:08}"], f"{what}: checkpoint of the last row")
        check("interrupted by" in content("run/run.log").decode(), f"{what}: in the log")
        report = content("run/report.html").decode()
        check(f'"ended":"interrupted by {name} after step' in report, f"{what}: in the report")
        emmy("--restart", "run", "--set", f"Time/Maximum steps={step + 2}", ranks=ranks)
        check(last["status"] == 0, f"{what}: goes on")
        check([row["step"] for row in rows("run")] == list(range(step + 3)), f"{what}: no gap")
        check(f"continued from step {step}, t = " in content("run/run.log").decode(),
              f"{what}: the log says where")


def early_signals():
    """Signals that come before the first step, at any time."""
    print("Signals while emmy starts", flush=True)
    for delay in (0.3, 0.5, 0.7, 0.9):
        shutil.rmtree("run", ignore_errors=True)
        last["words"] = [f"SIGUSR1 after {delay} s"]
        process = subprocess.Popen([EMMY, "block.prm", *sets(["Time/End time=1000"])], env=ENVIRONMENT,
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        while b"emmy" not in content(f"/proc/{process.pid}/comm"):
            time.sleep(0.01)
        # the program's own code runs, which the libraries' start is not
        while not int(next(line for line in content(f"/proc/{process.pid}/status").decode().splitlines()
                           if line.startswith("SigCgt")).split()[1], 16) >> (signal.SIGUSR1 - 1) & 1:
            time.sleep(0.01)
        check(not os.path.exists("run"), "signals are watched before the scene is built")
        time.sleep(delay - 0.3)
        process.send_signal(signal.SIGUSR1)
        last["text"] = process.communicate(timeout=60)[0].decode()
        last["status"] = process.returncode
        check(last["status"] == 75, f"after {delay} s: exit code 75")
        check(says("interrupted by SIGUSR1 after step"), f"after {delay} s: a step was made")


def clock():
    print("By the clock, and not at all", flush=True)
    for settings, expected in ((["Checkpoint/Every steps=0", "Checkpoint/Every minutes=1e-6"],
                                ["step-00000005", "step-00000006"]),
                               (["Checkpoint/Every steps=0", "Checkpoint/Every minutes=60"],
                                ["step-00000006"]),
                               (["Checkpoint/Every steps=0"], [])):
        shutil.rmtree("run", ignore_errors=True)
        emmy("block.prm", *sets(settings + ["Time/Maximum steps=6"]))
        there = sorted(os.listdir("run/checkpoints")) if os.path.isdir("run/checkpoints") else []
        check(last["status"] == 0 and there == expected, f"{settings}: {there}")


def damage():
    print("Damage", flush=True)
    newest, older = (f"run/checkpoints/step-{n:08}" for n in (12, 10))
    for name, place in (("head", 40), ("head", 3000), ("particles.0", 500), ("particles.0", 12),
                        ("head", -1), ("particles.0", -3)):
        reference_and_run()
        flip(f"{newest}/{name}", place)
        goes_on(f"byte {place} of {name}")
        check(says("a newer checkpoint is not used: the file"), "and says that the newest is not used")
        check(says("continued from step 10"), "and that it takes the one before")
        check(os.path.isdir("run/checkpoints/damaged-step-00000012"), "which is set aside")
    reference_and_run()
    os.truncate(f"{newest}/particles.0", 1000)
    goes_on("cut short, on two ranks", ranks=1)
    reference_and_run()
    os.truncate(f"{newest}/particles.0", 1000)
    os.remove(f"{older}/head")
    for ranks in (1, 2):
        refuses(f"both damaged, {ranks} ranks", "--restart", "run", ranks=ranks,
                because="no checkpoint in <run> can be used")
    reference_and_run()
    for folder in (newest, older):
        seal_again(f"{folder}/head", lambda data: data.replace(b"0.1.0", b"9.1.0", 1))
    refuses("another version", "--restart", "run", because="was written by emmy 9.1.0, and this is emmy")
    for folder in (newest, older):
        seal_again(f"{folder}/head", lambda data: data[:16] + struct.pack("<I", 77) + data[20:])
    refuses("another format", "--restart", "run", because="has format 77, and this emmy reads format 3")
    reference_and_run()
    for change, name in ((lambda text: text.replace(b"\n7,", b"\n8,"), "has no row of step 7"),
                         (lambda text: text[:900], "ends before step 12"),
                         (lambda text: b"a,b\n" + text, "has other columns than the run")):
        whole = content("run/ledger.csv")
        with open("run/ledger.csv", "wb") as file:
            file.write(change(whole))
        refuses(f"a ledger that {name}", "--restart", "run", because=name)
        with open("run/ledger.csv", "wb") as file:
            file.write(whole)
    with open("run/ledger.csv", "ab") as file:
        file.write(b"13,0.26,0.0")
    goes_on("a row that was cut")
    refuses("no folder", "--restart", "nowhere", because="there is no checkpoint in <nowhere/checkpoints>")


def any_byte(n):
    print(f"Any of the bytes, {n} times", flush=True)
    reference_and_run()
    os.rename("run", "kept")
    newest = "run/checkpoints/step-00000012"
    generator = random.Random(n)
    for i in range(n):
        shutil.rmtree("run", ignore_errors=True)
        shutil.copytree("kept", "run")
        names = sorted(os.listdir(newest))
        name = names[i % len(names)]
        data = bytearray(content(f"{newest}/{name}"))
        place, bit = generator.randrange(len(data)), generator.randrange(8)
        data[place] ^= 1 << bit
        with open(f"{newest}/{name}", "wb") as file:
            file.write(data)
        goes_on(f"bit {bit} of byte {place} of {name}")
        check(says("continued from step 10"), "from the checkpoint before")


def refusals():
    print("Other scenes", flush=True)
    reference_and_run()
    for setting in ("Materials/rubber/Young's modulus=2e5", "Method/Mapping=PIC", "Grid/Cells=16, 16",
                    "Time/Integrator=explicit", "Bodies/block/Points per direction=3",
                    "Effects/Gravity/Acceleration=0, -5", "Effects/Names=",
                    "Measurements/corner/Nearest to=1, 1", "Dimension=3"):
        path = setting.split("=")[0]
        for ranks in (1, 2) if "modulus" in setting else (1,):
            refuses(setting, "--restart", "run", "--set", setting, ranks=ranks,
                    because="dimensions, and the run in" if path == "Dimension" else path + " = ")
    check(says("3 dimensions"), "the dimension is named")
    with open("other.prm", "w", encoding="utf-8") as file:
        file.write(BLOCK.replace("1e5", "3e5").replace("Poisson's ratio = 0.3", "Poisson's ratio = 0.4"))
    refuses("another file", "--restart", "run", "other.prm", because="Young's modulus = 3e5 (it was: 1e5)")
    check(says("Poisson's ratio = 0.4 (it was: 0.3)"), "all differences are listed")
    refuses("another folder", "--restart", "run", "--set", "Output/Directory=other",
            because="a run goes on in its own folder")
    goes_on("the same file", more=["block.prm"])
    reference_and_run()
    goes_on("output and solver", more=sets(["Output/Frames=9", "Solver/Maximum iterations=40",
                                            "Checkpoint/Keep=1"]))
    check(len(os.listdir("run/checkpoints")) == 1, "Keep = 1")
    reference_and_run()
    emmy("--restart", "run", "--new-loads", *sets(["Effects/Gravity/Acceleration=0, -5",
                                                   "Time/Maximum steps=25"]))
    check(last["status"] == 0, "new loads, asked for")
    check(says("changed: Effects/Gravity/Acceleration = 0, -5 (it was: 3, -9.81)"), "are named")
    check(rows("run")[:13] == rows("reference")[:13] and rows("run")[13] != rows("reference")[13],
          "and act from then on")


def disks():
    print("Disks", flush=True)
    reference_and_run()
    mounted = not subprocess.call(["mount", "--bind", "run", "run"], stderr=subprocess.DEVNULL)
    if mounted and not subprocess.call(["mount", "-o", "remount,bind,ro", "run"], stderr=subprocess.DEVNULL):
        refuses("a folder that cannot be written", "--restart", "run", because="no file can be written in")
        subprocess.check_call(["umount", "run"])
        goes_on("and when it can")
    else:
        counts["skipped"] += 1
        print("skipped: nothing can be mounted here")
        return
    for ranks in (1, 2):
        os.makedirs("full", exist_ok=True)
        subprocess.check_call(["mount", "-t", "tmpfs", "-o", "size=120k", "tmpfs", "full"])
        emmy("block.prm", *sets(["Output/Directory=full/run", "Output/Frames=0", "Checkpoint/Every steps=2",
                                 "Checkpoint/Keep=40", "Time/Maximum steps=25"]), ranks=ranks)
        check(says("is not written: the file <full/run/checkpoints/step-"), f"full disk, {ranks} ranks: says so")
        check(says("No space left on device"), f"full disk, {ranks} ranks: says why")
        check(last["status"] is not None, f"full disk, {ranks} ranks: no rank waits")
        check(not [name for name in os.listdir("full/run/checkpoints") if name.endswith("new")],
              f"full disk, {ranks} ranks: nothing stays aside")
        shutil.rmtree("run", ignore_errors=True)
        shutil.copytree("full/run", "run")
        subprocess.check_call(["umount", "full"])
        if ranks == 1:
            goes_on("from what was written before the disk was full")
            check(says("continued from step"), "from a checkpoint of before")


def chains():
    print("Chains", flush=True)
    for ranks in (1, 2):
        reference_and_run()
        shutil.rmtree("second", ignore_errors=True)
        words = ["block.prm", *sets([
            "Start/From=run", "Output/Directory=second", "Effects/Names=gravity, point load",
            "Effects/Point load/Force=0; -50", "Effects/Point load/Points nearest to=2, 1",
            "Materials/rubber/Model=von Mises", "Materials/rubber/Yield stress=1e5",
            "Materials/rubber/Yield measure=deviatoric", "Time/Maximum steps=8", "Checkpoint/Every steps=4"])]
        emmy(*words, ranks=ranks)
        check(last["status"] == 0, f"a chain on {ranks} ranks runs")
        check(says("started from step 12, t = 0.24 s of <run>"), "and says from where")
        check(says("as in a virgin body:") and says("point_load_share"), "and names the fields that are new")
        first, begin = rows("run")[-1], rows("second")[0]
        for name in ("kinetic_energy", "strain_energy"):
            check(abs(begin[name] - first[name]) <= 1e-14 * abs(first[name]) and first[name] != 0.,
                  f"row 0 has the {name} of the last row: {begin[name]} and {first[name]}")
        check(begin["time"] == 0. and begin["step"] == 0. and begin["load_work"] == 0.
              and begin["balance_error"] == 0., "time, work and error begin at zero")
        check(begin["corner_x"] == first["corner_x"], "particles are where they were")
        largest = max(row["strain_energy"] + row["kinetic_energy"] for row in rows("second"))
        check(abs(rows("second")[-1]["balance_error"]) <= 1e-12 * largest, "the balance holds")
        uninterrupted = content("second/ledger.csv")
        shutil.rmtree("run")
        shutil.rmtree("second/checkpoints/step-00000008")
        emmy("--restart", "second", ranks=ranks)
        check(last["status"] == 0, "a chain is restarted without the run that it started from")
        check(content("second/ledger.csv") == uninterrupted, "and has the same ledger")
    reference_and_run()
    emmy("block.prm", *sets(["Start/From=run", "Start/Step=10", "Output/Directory=third",
                             "Time/Maximum steps=1"]))
    check(last["status"] == 0 and rows("third")[0]["kinetic_energy"] ==
          rows("run")[10]["kinetic_energy"], "a chosen step")
    refuses("a step that is not there", "block.prm", *sets(["Start/From=run", "Start/Step=11",
                                                            "Output/Directory=fourth"]),
            because="the last before it is of step 10")
    refuses("its own folder", "block.prm", "--overwrite", *sets(["Start/From=run"]),
            because="Output/Directory is the same folder")
    with open("other.prm", "w", encoding="utf-8") as file:
        file.write(BLOCK.replace("block", "brick"))
    refuses("other bodies", "other.prm", *sets(["Start/From=run", "Output/Directory=fourth"]),
            because="the bodies of that run are block, and those of this scene brick")
    refuses("a small grid", "block.prm", *sets(["Start/From=run", "Output/Directory=fourth",
                                                "Grid/Upper corner=1.5, 4"]),
            because="is outside of the grid")


def failures():
    print("Failed steps", flush=True)
    shutil.rmtree("run", ignore_errors=True)
    settings = sets(["Solver/Maximum iterations=1", "Time/Maximum halvings=1", "Time/Maximum steps=8"])
    for ranks in (1, 2):
        shutil.rmtree("run", ignore_errors=True)
        emmy("block.prm", "--set", "Time/Maximum steps=6")
        check(last["status"] == 0, "the first part runs")
        emmy("--restart", "run", *settings, ranks=ranks)
        check(last["status"] == 1, "a step fails")
        check(says("it is repeated with: emmy --restart run/failure"), "and says how it is repeated")
        cause = content("run/failure/cause.txt").decode()
        check("Step 7 from t = 0.12 s: Newton does not converge" in cause, "the cause is there")
        check("Remedy:" in cause and "weakest" in cause, "with a remedy and the weakest nodes")
        check("0.02 s: " in cause and "0.01 s: " in cause, "and both tries")
        emmy("--restart", "run/failure", ranks=ranks)
        check(last["status"] == 1 and says("Step 7 from t = 0.12 s: Newton does not converge"),
              "the step fails again")
        check(not os.path.exists("run/failure/failure"), "which leaves no further folder")
        emmy("--restart", "run/failure", "--set", "Solver/Maximum iterations=20", ranks=ranks)
        check(last["status"] == 0, "with another setting it does not fail")
        check([row["step"] for row in rows("run/failure")] == list(range(8)), "and it is one step")
        emmy("--restart", "run", "--set", "Solver/Maximum iterations=20")
        check(last["status"] == 0 and says("continued from step 6"), "the run goes on where it failed")
        check(rows("run")[7]["kinetic_energy"] == rows("run/failure")[7]["kinetic_energy"] or ranks > 1,
              "with the same step")
    emmy("block.prm", "--overwrite", "--set", "Time/Maximum steps=2")
    check(last["status"] == 0 and not os.path.exists("run/failure"), "a new run removes the old failure")


def main():
    # a disk is mounted where no one else sees it
    if "EMMY_MOUNTS" not in os.environ:
        for rights in ("-m", "-rm"):
            if not subprocess.call(["unshare", rights, "true"], stderr=subprocess.DEVNULL):
                os.environ["EMMY_MOUNTS"] = "yes"
                os.execvp("unshare", ["unshare", rights, sys.executable] + sys.argv)
    only = sys.argv[4:]
    with tempfile.TemporaryDirectory() as work:
        os.chdir(work)
        with open("block.prm", "w", encoding="utf-8") as file:
            file.write(BLOCK)
        for part in (signals, early_signals, clock, damage, refusals, disks, chains, failures):
            if not only or part.__name__ in only:
                part()
        for word in only:
            if word.startswith("any_byte="):
                any_byte(int(word.split("=")[1]))
        os.chdir("/")
    print(", ".join(f"{number} {name}" for name, number in counts.items()))
    sys.exit(counts["failed"] > 0)


main()
