#!/usr/bin/env python3
"""Every public entry in include/ says what it is: doxygen, with the settings of
the manual, has nothing to complain of.

  documented.py SOURCE

Without doxygen the test is skipped, and says so; where CI is set it fails."""
import os
import shutil
import subprocess
import sys
import tempfile

source = os.path.abspath(sys.argv[1])
sys.path.insert(0, os.path.join(source, "doc"))
import manual  # doc/manual.py: headers as doxygen should read them


def warnings_of(folder):
    with open(os.path.join(source, "doc", "Doxyfile.in"), encoding="utf-8") as file:
        settings = file.read().replace("@CMAKE_SOURCE_DIR@", folder).replace("@CMAKE_BINARY_DIR@", folder)
    settings += f"\nINPUT = {folder}/include\nFILTER_PATTERNS =\nIMAGE_PATH =\nGENERATE_HTML = NO\nWARN_LOGFILE = {folder}/warnings\n"
    os.makedirs(os.path.join(folder, "doc"))
    done = subprocess.run(["doxygen", "-"], input=settings, capture_output=True, text=True, cwd=folder)
    with open(os.path.join(folder, "warnings"), encoding="utf-8") as file:
        found = file.read()
    return found if done.returncode == 0 else found + done.stderr


def main():
    if not shutil.which("doxygen"):
        print("NO DOXYGEN: comments were not looked at. Install the package doxygen.")
        return 1 if os.environ.get("CI") else 77
    n_headers = 0
    with tempfile.TemporaryDirectory() as folder:
        for path, _, names in os.walk(os.path.join(source, "include")):
            target = os.path.join(folder, os.path.relpath(path, source))
            os.makedirs(target)
            for name in names:
                with open(os.path.join(path, name), encoding="utf-8") as file:
                    text = manual.header(file.read())
                with open(os.path.join(target, name), "w", encoding="utf-8") as file:
                    file.write(text)
                n_headers += 1
        found = warnings_of(folder)
    print(found + f"{n_headers} headers, {len(found.splitlines())} warnings")
    return 1 if found or not n_headers else 0


if __name__ == "__main__":
    sys.exit(main())
