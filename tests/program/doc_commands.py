#!/usr/bin/env python3
"""Every command of README.md, CONTRIBUTING.md and doc/*.md is run: all lines
that begin with one of PROGRAMS.

    doc_commands.py SOURCE_ROOT EMMY_BUILD [-v] [PAGE...]

The shell takes commands as they are written, page by page, in a folder that
looks like the root of the project. emmy is the real one and makes one step.
What would take minutes or another machine has a stand-in, which says why, and
looks whether files, options and names exist. The pages of single tutorials are
run in full by the test tutorials.
"""
import ast
import concurrent.futures
import glob
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import threading
import time

# Words that stand for the reader's own
PLACES = {"FILE.prm": "prm/examples/block.prm", "TOPIC": "contact", "N": "2", "I": "20", "FOLDER": "results/my-run",
          "EMMY": "build/emmy", "[EMMY]": "build/emmy", "NEW_BUILD": "build", "OLD_BUILD": "build"}

# In a sentence these name a program or an option, and are no whole commands
NAMES = {"./run", "ctest", "mpirun", "emmy study", "emmy verify", "emmy --check", "emmy --help", "emmy --restart",
         "emmy --restart results/my-run --set ...", "mpirun --mca mpi_yield_when_idle 1"}

# Not run, and why; the rest of such a line is looked up
NEED_ALL = {  # words in the log of a whole run, which takes minutes: the program has them
    'grep -c "; halved to" results/7.1b/run.log': "halved to ",
    'grep "converged only" results/7.1a/run.log': "converged only"}

PROGRAMS = r"\./run|emmy|mpirun|cmake|cpack|ctest|sbatch|apt-get|cp|rm|sed|grep|for|build(?:-[\w-]+)?/\S+|" \
           r"tests/\S+\.(?:sh|py)|doc/\w+\.py"
# a run that can go on, and one that has failed
MY_RUN = """emmy prm/examples/block.prm --set Output/Directory=results/my-run --set "Checkpoint/Every steps=1"
cp -r results/my-run results/failing
emmy --restart results/failing --set "Solver/Maximum iterations=1" --set "Time/Maximum halvings=0" || true
mv results/failing/failure results/my-run/
"""
ONE_STEP = ["--set", "Time/Maximum steps=1", "--set", "Output/Pictures=false"]


# ---- what is run in place of a program: functions of its arguments -----------

def need(condition, what):
    if not condition:
        sys.exit(what)


def need_files(words):
    """All that look like files of the project are there."""
    for word in words:
        if re.fullmatch(r"(?:prm|doc|tests)/[^=]*|[\w./-]+\.prm", word):
            need(os.path.exists(word), f"there is no <{word}>")


def need_known(words, file):
    """A program's text knows each option and word."""
    with open(file, encoding="utf-8") as opened:
        text = opened.read()
    for word in words:
        if re.match(r"--?[a-z]|[a-z-]+$", word) and word not in ("build", "mpirun"):
            name = re.escape(word.lstrip("-"))
            need(re.search(rf"-{name}(?![\w-])|[\"'/]{name}[\"',]|\b{name}\)", text),
                 f"{file} does not know <{word}>")


def emmy(words, tools):
    """The real one. A run makes one step. `verify` takes minutes, and has a test of its name; studies of the
    project take minutes, and the test `scene_files` reads the members of all."""
    if words[:1] == ["verify"]:
        return need_known(words, "source/study/command_line.cc")
    if len(words) == 2 and re.match(r"prm/studies/(?!block-dt)", words[1]) and words[0] == "study":
        return need_files(words)
    elif words[:1] == ["study"] and "--print-parameters" not in words:
        words = ["study", "--check", *words[1:]]
        if "--tolerance" in words: # of members that have run
            at = words.index("--tolerance")
            float(words[at + 1])
            del words[at:at + 2]
    elif not {"--check", "--list", "--help", "--print-parameters"} & set(words):
        need(words, "nothing to do")
        words = words + ONE_STEP
        if "--restart" in words: # the run that is there made one
            words += ["--set", "Time/Maximum steps=2"]
        elif words[0] == "prm/examples/block.prm": # stands for many a FILE.prm
            words.append("--overwrite")
    if "OMPI_COMM_WORLD_SIZE" not in os.environ: # alone: a search for neighbours less
        os.environ.update(OMPI_MCA_ess_singleton_isolated="1", OMPI_MCA_pml="ob1", OMPI_MCA_btl="self")
    return [tools["emmy"], *words]


def run(words, tools):
    """The start script, without installing and building."""
    if words[:1] == ["--help"]:
        return [os.path.join(tools["root"], "run"), "--help"]
    if words[:1] == ["benchmark"]: # minutes
        return need_known(words[1:], "tests/performance/benchmark.cc")
    if words[:1] == ["test"]:
        return ctest(["--test-dir", "build", *words[1:]], tools)
    if words[:1] == ["-n"]:
        return mpirun(["-np", words[1], "emmy", *words[2:]], tools)
    return emmy(words[1:] if words[:1] == ["--"] else words, tools)


def mpirun(words, tools):
    """Two ranks at most, as tests run on small machines."""
    options = ["--oversubscribe", "--bind-to", "none"]
    while words and words[0].startswith("-"):
        n = 3 if words[0] == "--mca" else 2
        options += [words[0], "2"] if words[0] == "-np" and int(words[1]) > 2 else words[:n]
        words = words[n:]
    if words[:2] == ["emmy", "study"] and "block-dt" not in words[2]:
        return emmy(words[1:], tools)
    return [tools["mpirun"], *options, *words]


def cmake(words, tools):
    """So this build came about: folders, targets and variables are looked up."""
    i = 0
    while i < len(words):
        word, value = words[i], words[i + 1] if i + 1 < len(words) else ""
        i += 1 if word.startswith("-D") else 2
        if word == "-S":
            need(os.path.exists(value + "/CMakeLists.txt"), f"there is no <{value}/CMakeLists.txt>")
        elif word.startswith("-Demmy_DIR="):
            need(os.path.exists(word.split("=")[1] + "/emmyConfig.cmake"), f"<{word}>: no emmyConfig.cmake there")
        elif word.startswith("-D"):
            with open("build/CMakeCache.txt", encoding="utf-8") as file:
                need("\n" + re.split("[=:]", word[2:])[0] + ":" in file.read(), f"unknown variable <{word}>")
        elif word == "--target":
            need_target(value)
            while i < len(words) and not words[i].startswith("-"):
                need_target(words[i])
                i += 1
        else:
            need(word in ("-B", "--build", "--install", "--prefix", "--parallel"), f"cmake: <{word}>?")


def need_target(name):
    text = ""
    for file in ["CMakeLists.txt", "tests/CMakeLists.txt"]:
        with open(file, encoding="utf-8") as opened:
            text += opened.read()
    need(re.search(rf"(?:add_executable|add_custom_target|add_library)\({name}\b|emmy_test\({name.removeprefix('test_')} ", text),
         f"there is no target <{name}>")


def ctest(words, tools):
    """Tests in a test would not end: those that are meant are listed."""
    need(words[:2] == ["--test-dir", "build"] or words[:1] != ["--test-dir"], "in which build folder?")
    words = [word for word in words if word not in ("--test-dir", "build")]
    listed = subprocess.run([tools["ctest"], "--test-dir", tools["build"], "-N", *words],
                            capture_output=True, text=True)
    need(listed.returncode == 0 and "Total Tests: 0" not in listed.stdout, listed.stdout + listed.stderr)


def cpack(words, tools):
    """Minutes: the generator is the one of CMakeLists.txt."""
    need(words == ["-G", "DEB"], "which generator?")


def sbatch(words, tools):
    """No queue here."""
    need_files(words)
    return ["bash", "-n", words[0]]


def apt_get(words, tools):
    """Tests install nothing."""
    need(words[:1] == ["install"], "only install")


def script(name, words):
    """Minutes, on a machine that does nothing else."""
    need(os.access(name, os.X_OK), f"{name} cannot be started")
    need_files(words)
    need_known(words, name)
    if name.endswith(".py"):
        with open(name, encoding="utf-8") as file:
            ast.parse(file.read())
        return None
    with open(name, encoding="utf-8") as file:
        shell = os.path.basename(file.readline().split()[-1])
    return [shell, "-n", name]


def test_program(name, words):
    """Up to minutes: ctest runs it with what is short."""
    need_target(os.path.basename(name))
    need_files(words)


def built_elsewhere(name, words):
    """Programs of tutorials: the test `tutorials` builds and runs them."""
    need_files(words)


STAND_INS = {"emmy": emmy, "run": run, "mpirun": mpirun, "cmake": cmake, "ctest": ctest, "cpack": cpack,
             "sbatch": sbatch, "apt-get": apt_get}


def stand_in(name, words, tools):
    if name in STAND_INS:
        command = STAND_INS[name](words, tools)
    elif name.startswith("build/tests/"):
        command = test_program(name, words)
    elif name.startswith("build-"):
        command = built_elsewhere(name, words)
    else:
        command = script(name, words)
    if command:
        os.execvp(command[0], command)


# ---- collecting --------------------------------------------------------------

def is_command(text):
    return re.match(rf"(?:{PROGRAMS})(?=\s|$)", text)


def commands_of(text):
    """(line, command) of the blocks of a page, and then of its sentences, where line is 0."""
    result, sentences = [], []
    block, start, language = None, 0, ""
    for number, line in enumerate(text.split("\n") + [""], 1):
        if line.startswith("```") and block is None:
            block, start, language = [], number + 1, line[3:]
        elif line.startswith("```"):
            if not language and block and is_command(block[0]):
                result.append((start, "\n".join(block)))
            block = None
        elif block is not None:
            block.append(line)
        elif line.startswith("    "):
            if result and result[-1][1].endswith("\\"):
                result[-1] = (result[-1][0], result[-1][1][:-1] + line.strip())
            elif is_command(line.strip()):
                result.append((number, line.strip()))
            sentences.append("")
        else:
            sentences.append(line)
    for quoted in re.findall(r"`([^`]+)`", "\n".join(sentences)):
        command = " ".join(quoted.split())
        if is_command(command) and command not in NAMES and " " in command:
            result.append((0, command))
    return result


def in_place(command):
    """With words for those that stand for the reader's."""
    if "emmy study" in command:
        command = command.replace("FILE.prm", "prm/studies/block-dt.prm")
    for word, value in PLACES.items():
        command = re.sub(rf"(?<![\w./-]){re.escape(word)}(?![\w.-])", value, command)
    return command


class Folder:
    """Looks like the root of the project after a build; commands are run in it."""

    def __init__(self, folder, root, build):
        self.folder, bin_folder = folder, os.path.join(folder, ".bin")
        for name in ["tests", "source", "CMakeLists.txt"]:
            os.symlink(os.path.join(root, name), os.path.join(folder, name))
        for name in ["prm", "doc"]: # commands write there
            shutil.copytree(os.path.join(root, name), os.path.join(folder, name))
        for name in [".bin", ".mpi", "build", "build/tests", "results"]:
            os.mkdir(os.path.join(folder, name))
        for name in os.listdir(build):
            if name not in ("emmy", "tests"):
                os.symlink(os.path.join(build, name), os.path.join(folder, "build", name))
        tools = {name: shutil.which(name) for name in ["mpirun", "ctest"]}
        tools.update(root=root, build=build, emmy=os.path.join(build, "emmy"))
        self.call = shlex.join([sys.executable, os.path.abspath(__file__), "--stand-in", repr(tools)])
        for name in STAND_INS:
            self.write(os.path.join(bin_folder, name), name)
        for place in ["run", "build/emmy"]:
            self.write(os.path.join(folder, place), os.path.basename(place))
        self.environment = dict(os.environ, PATH=bin_folder + ":" + os.environ["PATH"],
                                # what mpirun tidies up may not be another's
                                OMPI_MCA_orte_tmpdir_base=os.path.join(folder, ".mpi"))

    def write(self, path, name):
        with open(path, "w", encoding="utf-8") as file:
            file.write(f"#!/bin/sh\nexec {self.call} {name} \"$@\"\n")
        os.chmod(path, 0o755)

    def run(self, command):
        # what lies in folders that are not here, or is not for a test
        command = re.sub(r"(?m)(^|[;|&]\s*|\b(?:do|then)\s+)"
                         r"(build/tests/\S+|build-[\w-]+/\S+|(?:tests|doc)/\S+\.(?:sh|py))(?=\s|$)",
                         lambda found: f"{found[1]}{self.call} {found[2]}", command)
        return subprocess.run(["bash", "-e", "-o", "pipefail", "-c", command], cwd=self.folder, env=self.environment,
                              capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=250)

    def clean(self):
        """The results of a page's own, and what pages take to be there: a run that can go on, one that failed."""
        for name in os.listdir(os.path.join(self.folder, "results")):
            if name != "my-run":
                shutil.rmtree(os.path.join(self.folder, "results", name))
        for name in ["my-scene.prm", "my-run.prm"]:
            shutil.copy(os.path.join(self.folder, "prm/examples/block.prm"), os.path.join(self.folder, name))


class Book:
    """Follows pages, and counts."""

    def __init__(self, root, build):
        self.root, self.build = root, build
        self.n_commands, self.wrong, self.seen, self.lock = 0, 0, set(), threading.Lock()

    def follow(self, pages):
        with tempfile.TemporaryDirectory() as folder:
            here = Folder(folder, self.root, self.build)
            made = here.run(MY_RUN)
            if made.returncode:
                self.complain("no run to go on with", made)
            while True:
                with self.lock:
                    page = pages.pop(0) if pages else None
                if page is None:
                    return
                self.page(page, here)

    def page(self, page, here):
        here.clean()
        with open(os.path.join(self.root, page), encoding="utf-8") as file:
            commands = commands_of(file.read())
        for line, command in commands:
            command = in_place(command)
            if not line: # sentences do not follow one another
                if command in self.seen:
                    continue
                here.clean()
            self.seen.add(re.sub(r" +#.*", "", command))
            if command in NEED_ALL:
                command = f"grep -rqF '{NEED_ALL[command]}' source"
            start = time.monotonic()
            try:
                done = here.run(command)
            except subprocess.TimeoutExpired as late:
                done = subprocess.CompletedProcess(command, -1, "", str(late))
            with self.lock:
                self.n_commands += 1
            if "-v" in sys.argv:
                print(f"{time.monotonic() - start:6.2f} s  {page}:{line or ''}  {command}", flush=True)
            if done.returncode and not (done.returncode == 1 and command.startswith("grep -c")):
                self.complain(f"{page}:{line or ' in a sentence'}: {command}", done)

    def complain(self, what, done):
        with self.lock:
            self.wrong += 1
        print(f"FAILED: {what}\n{done.stdout[-800:]}{done.stderr[-1500:]}", flush=True)


def main():
    arguments = [word for word in sys.argv[1:] if word != "-v"]
    root, build = map(os.path.abspath, arguments[:2])
    pages = arguments[2:] or ["README.md", "CONTRIBUTING.md", "doc/tutorials/README.md"] + \
        sorted(os.path.relpath(page, root) for page in glob.glob(os.path.join(root, "doc/*.md")))
    n_pages, book = len(pages), Book(root, build)
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for worker in [pool.submit(book.follow, pages) for _ in range(2)]:
            worker.result()
    print(f"{book.n_commands} commands of {n_pages} pages, {book.wrong} failed")
    return 1 if book.wrong else 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--stand-in"]:
        sys.exit(stand_in(sys.argv[3], sys.argv[4:], ast.literal_eval(sys.argv[2])))
    sys.exit(main())
