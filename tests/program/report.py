#!/usr/bin/env python3
"""The page of a run, as a browser shows it: numbers of the ledger, curves, the
film, the words of the scene; and a run without the library that draws.

  report.py EMMY SOURCE

Without Chromium the test is skipped, and says so; where CI is set it fails."""

import base64
import csv
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

emmy, source = map(os.path.abspath, sys.argv[1:3])
failed = []


def check(fact, what):
    print(("ok      " if fact else "FAILED: ") + what)
    if not fact:
        failed.append(what)


def run(folder, *settings, environment=None):
    words = [emmy, os.path.join(source, "prm", "examples", "block.prm"), "--overwrite"]
    for setting in ("Time/End time=0.2", "Output/Pictures=false", "Output/Frames=4",
                    "Output/Directory=" + folder) + settings:
        words += ["--set", setting]
    return subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          env=dict(os.environ, **(environment or {})))


def dom_of(browser, page):
    result = subprocess.run(
        [browser, "--headless", "--no-sandbox", "--disable-gpu", "--window-size=1200,2000",
         "--host-resolver-rules=MAP * ~NOTFOUND",  # no network
         "--user-data-dir=" + tempfile.mkdtemp(dir="."), "--dump-dom", "file://" + os.path.abspath(page)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=200)
    return result.stdout


def main():
    browser = next((found for found in map(shutil.which, ("chromium", "chromium-browser", "google-chrome")) if found), None)
    if browser is None:
        print("NO BROWSER: report.html was not looked at. Install the package chromium.")
        sys.exit(1 if os.environ.get("CI") else 77)
    plain = run("plain")
    check(plain.returncode == 0, "the run ends well")
    dom = re.sub(r"<script>.*?</script>", "", dom_of(browser, "plain/report.html"), flags=re.S)
    body = re.search(r"<body[^>]*>", dom).group()
    check('data-ready="yes"' in body, "the page's script comes to its end")

    with open("plain/ledger.csv") as file:
        rows = list(csv.DictReader(file))
    cells = dict(re.findall(r'data-column="([^"]*)">([^<]*)<', dom))
    check(set(cells) == set(rows[-1]), "its table has the columns of the ledger")
    check(all(float(cells[name]) == float(rows[-1][name]) for name in rows[-1]),
          "and the numbers of the last row, to the last digit")
    # energies, balance, two momenta, works, Newton, time step, and any column
    check('data-curves="8"' in body, "eight pictures of curves")
    check(len(re.findall(r"<canvas", dom)) >= 8 + 1, "each has its canvas")
    check("linear_momentum_x" in dom and "total" in dom and "dygraph-legend" in dom, "curves are named")
    check(re.search(r"dygraph-legend.*?kinetic_energy_grid_old</span>", dom.split('id="any"')[1], re.S),
          "the column that one may choose is at first one that no picture has")
    check('data-frames="5"' in body, "the film has five frames")
    # the last frame: how many particles
    check(re.search(r'data-first="[-0-9.e]+ [-0-9.e]+ 64"', body) is not None, "with 64 particles")
    first = re.search(r'data-first="([-0-9.e]+) ([-0-9.e]+) 64"', body)
    check(first is not None and 1.5 < float(first.group(1)) < 2.5 and -0.3 < float(first.group(2)) < 1.2,
          "the first one is in the block")
    check("strain energy" in dom.split('id="label"')[1][:60], "its colours are named")
    check("P-wave modulus" in dom, "the scene card is there")
    check('href="ledger.csv"' in dom and 'href="parameters.prm"' in dom, "files are linked")
    check("--overwrite" in dom and "parameters.prm" in dom, "it says how to repeat the run")
    check(re.search(r"<td>Newton", dom) or "internal force" in dom, "it says where the time went")
    check("http" not in dom, "nothing comes from the network")

    check('data-lines="0"' in body, "without tools there are no lines")
    wall = "Effects/Tools/wall/"
    tool = run("tool", "Effects/Names=gravity, tools", "Effects/Tools/Names=wall", wall + "Shape=plane",
               wall + "Reference point=3.1, 0", wall + "plane/Normal=-1, 0")
    check(tool.returncode == 0, "a run with a tool ends well")
    shown = json.loads(re.search(r'"film":(\{.*?\]\})', open("tool/report.html").read()).group(1))
    codes = [base64.b64decode(frame["lines"]) for frame in shown["frames"]]
    low, high = shown["line_ranges"][0]
    places = [low + (high - low) * int.from_bytes(code[i:i + 2], "little") / 65535
              for code in codes for i in range(0, len(code), 4)]
    check(len(codes) == 5 and all(codes) and all(abs(x - 3.1) < 1e-6 for x in places), "its film has the tool, in its place")
    check(f'data-lines="{len(codes[-1]) // 8}"' in dom_of(browser, "tool/report.html"), "and the page draws it")

    bare = run("bare", environment={"EMMY_DYGRAPHS": "/nowhere"})
    check(bare.returncode == 0 and "libjs-dygraphs" in bare.stdout, "without the library a run ends well and says so")
    dom = dom_of(browser, "bare/report.html")
    check('data-curves="0"' in dom and 'data-ready="yes"' in dom and "No curves" in dom and 'data-frames="5"' in dom,
          "its page has all but the curves")
    # the film of a run that went on is that of one that nobody stopped
    film = lambda folder: re.search(r'"film":(\{.*?\]\})', open(folder + "/report.html").read()).group(1)
    cut = run("cut", "Checkpoint/Every steps=1", "Time/Maximum steps=5")
    check(cut.returncode == 0 and film("cut") != film("plain"), "a run that ends early has another film")
    again = subprocess.run([emmy, "--restart", "cut", "--set", "Time/Maximum steps=0"],
                           stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    check(again.returncode == 0 and film("cut") == film("plain"), "restarted, it has all frames, to the last bit")
    again = subprocess.run([emmy, "--restart", "cut"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    check(again.returncode == 0 and "the run is finished" in again.stdout and "Time/End time=0.4" in again.stdout,
          "a finished run says what to raise")
    again = subprocess.run([emmy, "--restart", "cut", "--set", "Time/End time=0.3", "--set",
                            "Output/Picture field=pressure"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    check(again.returncode == 0 and film("cut").count('"time"') < 5, "of another field, the film begins anew")
    check(run("none", "Output/Report=false").returncode == 0 and not os.path.exists("none/report.html"),
          "Report = false leaves it out")
    print(f"{len(failed)} failed")
    sys.exit(1 if failed else 0)


work = tempfile.mkdtemp(prefix="report-")
os.chdir(work)
try:
    main()
finally:
    os.chdir("/")
    shutil.rmtree(work, ignore_errors=True)
