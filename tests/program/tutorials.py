#!/usr/bin/env python3
"""The tutorials, built as their readers would, do what their pages say.

    tutorials.py SOURCE_ROOT EMMY_BUILD CMAKE MPI_LAUNCHER [--write] [--built FOLDER]

All commands of the pages run in their order; what those before a block
```out print must be what stands there (--write puts it there). Then what is
true of every program outside emmy: which headers a material needs, messages
that know new names, an installation that has all such a program needs.
"""
import csv
import os
import re
import shlex
import subprocess
import sys
import tempfile

n_checks, failures = 0, []


def check(name, holds, more=""):
    global n_checks
    n_checks += 1
    if not holds:
        failures.append(name)
        print(f"FAILED: {name}\n{more}", flush=True)


def run(command, folder, limit=300):
    environment = dict(os.environ, OMPI_MCA_odls_base_sigkill_timeout="0")
    if "--oversubscribe" not in command: # a search for neighbours less
        environment.update(OMPI_MCA_ess_singleton_isolated="1", OMPI_MCA_pml="ob1", OMPI_MCA_btl="self")
    result = subprocess.run(command, cwd=folder, env=environment, timeout=limit,
                            capture_output=True, text=True, stdin=subprocess.DEVNULL)
    return result.returncode, result.stdout, result.stderr


def command_of(line, launcher):
    words = shlex.split(line)
    if words[0] == "mpirun":
        words[:1] = [launcher, "--oversubscribe", "--bind-to", "none"]
    return words


def follow(page, folder, launcher, write):
    """Run what a page says; compare what it says is printed."""
    with open(page, encoding="utf-8") as file:
        text = file.read()
    printed, pieces, position = "", [], 0
    for found in re.finditer(r"^    ((?:build-tutorials/|mpirun )[^\n]*)\n|^```out\n(.*?)^```\n", text, re.S | re.M):
        if found[1]:
            status, out, err = run(command_of(found[1], launcher), folder)
            check(f"{page}: {found[1]}", status == 0 and not err, out[-2000:] + err[-2000:])
            printed += out
            continue
        pieces += [text[position:found.start()], "```out\n" + printed + "```\n"]
        position = found.end()
        if not write:
            check(f"{page}: what it says is printed", printed == found[2], printed)
        printed = ""
    if write:
        with open(page, "w", encoding="utf-8") as file:
            file.write("".join(pieces) + text[position:])


def headers_of(folder, program):
    """Headers of emmy that a program reads itself, without those read in advance."""
    with open(os.path.join(folder, "build-tutorials", "compile_commands.json"), encoding="utf-8") as file:
        lines = re.findall(r'"command": "(.*)"', file.read())
    line = next(line for line in lines if line.endswith(program + ".cc")).replace('\\"', '"')
    words = shlex.split(line.replace("\\\\", "\\"))
    if "ccache" in words[0]:
        words.pop(0)
    for option in ["-include", "-o"]:
        if option in words:
            i = words.index(option)
            del words[i:i + 2]
    words[words.index("-c")] = "-M"
    status, out, err = run(words, os.path.join(folder, "build-tutorials"))
    check("the compiler lists headers", status == 0, err[-2000:])
    return sorted(set(re.findall(r"include/emmy/(\S+\.h)", out)))


def outside(root, folder):
    """What holds of programs outside emmy."""
    headers = headers_of(folder, "step-3")
    check("a material reads the interface of materials", "material/material.h" in headers, str(headers))
    check("and no other material, no effect, and of the layers above only the program",
          not [h for h in headers if re.match(r"(material/(hencky|von_mises|stress_rules)|grid|particles|transfer|effects|"
                                              r"solve|step|output|run)", h)], str(headers))

    def says(program, arguments, words, status=0):
        scene = [os.path.join(root, f"doc/tutorials/{program}/{program}.prm")] if arguments[0] == "SCENE" else []
        found, out, err = run([f"build-tutorials/{program}", *scene, *arguments[1 if scene else 0:]], folder)
        text = " ".join((out + err).split())
        check(f"{program} {' '.join(arguments)}: {words}", found == status and words in text, text[-1500:])

    says("step-3", ["SCENE", "--set", "Materials/gum/Model=my neo-Hook"], "did you mean <my neo-Hooke>?", 1)
    says("step-3", ["--print-parameters"], "set Model = my neo-Hooke")
    says("step-3", ["SCENE", "--check", "--all"], "material gum 0 0 Newton, internal force: my neo-Hooke")
    says("step-4", ["SCENE", "--set", "Effects/Names=strem"], "did you mean <stream>?", 1)
    says("step-4", ["SCENE", "--set", "Effects/Stream/Rate=0"], "it is required and must be positive (1/s)", 1)
    says("step-4", ["--list"], "stream a stream that drags bodies along")
    says("step-4", ["SCENE", "--check"], "stream 0 0 Newton: mass times velocity ledger stream_loss, stream_work")
    says("step-4", ["SCENE", "--set", "Output/Directory=price"], "stream_loss")
    says("step-4", ["SCENE", "--set", "Effects/Names=", "--set", "Output/Directory=free"],
         "section Effects/Stream is not used, because Effects/Names does not list <stream>")
    with open(os.path.join(folder, "free/ledger.csv"), encoding="utf-8") as file:
        check("not named: no column", "stream" not in file.readline())


def column(folder, name):
    with open(os.path.join(folder, "ledger.csv"), encoding="utf-8") as file:
        return [float(line[name]) for line in csv.DictReader(file)]


def effect(root, folder, launcher):
    """What holds of step 4's effect beyond its page."""
    scene = os.path.join(root, "doc/tutorials/step-4/step-4.prm")

    def ledger(name, *settings, launch=()):
        status, out, err = run([*launch, "build-tutorials/step-4", scene, "--set", "Output/Directory=" + name,
                                "--set", "Output/Pictures=false", "--overwrite", *settings], folder)
        check(f"step-4 {name} runs", status == 0, out[-1000:] + err[-1000:])
        return os.path.join(folder, name)

    # without the line of the derivative residuals fall by 1/32 only, and it takes 6 iterations
    iterations = column(ledger("alone"), "newton_iterations")
    check("step-4: Newton has the derivative", max(iterations) <= 4, str(iterations))
    across = ["--set", "Bodies/block/box/Lower corner=1.25, 1.25", "--set", "Bodies/block/box/Upper corner=4.75, 4.75",
              "--set", "Time/Maximum steps=3"]
    losses = [column(ledger(f"on {n}", *across, launch=[launcher, "--oversubscribe", "--bind-to", "none", "-np", str(n)]),
                     "stream_loss")[-1] for n in (1, 2)]
    check("step-4: two ranks lose what one loses", losses[0] > 0.1 and abs(losses[1] / losses[0] - 1.) < 1e-12, str(losses))
    with open(scene, encoding="utf-8") as file:
        text = file.read()
    for old, new in [("Dimension = 2", "Dimension = 3"), ("= 0, 0\n", "= 0, 0, 0\n"), ("= 8, 6\n", "= 8, 6, 6\n"),
                     ("= 2.25, 2.25", "= 2.25, 2.25, 2.25"), ("= 3.75, 3.75", "= 3.75, 3.75, 3.75"),
                     ("Velocity = 1, 0", "Velocity = 1, 0, 0"), ("0.8*(y - 3)\n", "0.8*(y - 3); 0\n")]:
        check(f"step-4.prm has <{old}>", old in text)
        text = text.replace(old, new)
    scene = os.path.join(folder, "space.prm")
    with open(scene, "w", encoding="utf-8") as file:
        file.write(text)
    check("step-4: it loses in space too", column(ledger("space", "--set", "Time/Maximum steps=2"), "stream_loss")[-1] > 0.1)


def main():
    arguments = sys.argv[1:]
    write = "--write" in arguments
    built = arguments[arguments.index("--built") + 1] if "--built" in arguments else ""
    root, build, cmake, launcher = [os.path.abspath(a) if i < 2 else a for i, a in enumerate(arguments[:4])]
    # beside emmy's own, so that a compiler cache finds the same paths in any checkout
    with tempfile.TemporaryDirectory(dir=build) as folder:
        os.symlink(os.path.join(root, "doc"), os.path.join(folder, "doc"))
        target = os.path.join(folder, "build-tutorials")
        if built:
            os.symlink(os.path.abspath(built), target)
        else:
            with open(os.path.join(build, "CMakeCache.txt"), encoding="utf-8") as file:
                launcher_of_compiler = re.findall(r"^CMAKE_CXX_COMPILER_LAUNCHER:\w+=(.+)$", file.read(), re.M)
            for command in [[cmake, "-S", "doc/tutorials", "-B", "build-tutorials", "-Demmy_DIR=" + build,
                             "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON",
                             *("-DCMAKE_CXX_COMPILER_LAUNCHER=" + name for name in launcher_of_compiler)],
                            [cmake, "--build", "build-tutorials", "--parallel", "2"]]:
                status, out, err = run(command, folder, 1400)
                check(" ".join(command), status == 0, out[-3000:] + err[-3000:])
        if not failures:
            for n in range(1, 9):
                follow(os.path.join(root, f"doc/tutorials/step-{n}/README.md"), folder, launcher, write)
            outside(root, folder)
            effect(root, folder, launcher)
            status, out, err = run([cmake, "--install", build, "--prefix", os.path.join(folder, "installed")], folder)
            check("it can be installed", status == 0, err)
            status, out, err = run([cmake, "-S", os.path.join(root, "doc/tutorials"), "-B", "other",
                                    "-DCMAKE_PREFIX_PATH=" + os.path.join(folder, "installed")], folder)
            check("programs find the installation", status == 0, err)
    print(f"{n_checks} checks, {len(failures)} failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
