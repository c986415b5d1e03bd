#!/usr/bin/env python3
"""Draw the pictures of the gallery: run the scenes of prm/examples and
prm/ground, and keep the particles of each in doc/pictures/gallery, at half the
size that a run draws them.

    doc/gallery.py EMMY                  # scenes that have no picture yet
    doc/gallery.py EMMY FILE.prm...      # these
    doc/gallery.py --draw FOLDER PNG     # the picture of results that are there

The longest of the scenes takes minutes. Needs gnuplot.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

import manual

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def draw(results, picture):
    """particles.png of a run once more, with half the pixels."""
    pictures = os.path.join(results, "pictures")
    script = manual.read(os.path.join(pictures, "particles.gp"))

    def half(found):
        return found[1] + ",".join(str(round(float(n) / 2.)) for n in found[2].split(","))

    lines = []
    for line in script.split("\n"):
        if "set terminal png" in line:
            line = re.sub(r"(size )(\d+,\d+)", half, line)
            line = re.sub(r"(font 'Sans,)(\d+)", half, line)
            line = re.sub(r"(linewidth )[\d.]+", r"\g<1>1.3", line)
            line = re.sub(r"(pointscale )[\d.]+", r"\g<1>1.1", line)
        lines.append(line)
    text = "\n".join(lines).replace("set output 'particles.'", "set output 'half.'")
    with open(os.path.join(pictures, "half.gp"), "w", encoding="utf-8") as file:
        file.write(text)
    subprocess.run(["gnuplot", "half.gp"], cwd=pictures, check=True, capture_output=True)
    os.makedirs(os.path.dirname(picture), exist_ok=True)
    shutil.copy(os.path.join(pictures, "half.png"), picture)


def picture_of(scene):
    folder, name = os.path.split(os.path.relpath(os.path.abspath(scene), ROOT))
    return os.path.join(ROOT, "doc/pictures/gallery", f"{os.path.basename(folder)}-{name.removesuffix('.prm')}.png")


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    if sys.argv[1] == "--draw":
        return draw(sys.argv[2], os.path.abspath(sys.argv[3]))
    emmy = os.path.abspath(sys.argv[1])
    scenes = [os.path.abspath(scene) for scene in sys.argv[2:]]
    for scene in scenes or manual.scenes_of_gallery(ROOT):
        picture = picture_of(scene)
        if not scenes and os.path.exists(picture):
            continue
        with tempfile.TemporaryDirectory() as folder:
            print(scene, flush=True)
            done = subprocess.run([emmy, scene, "--set", f"Output/Directory={folder}/run"], cwd=ROOT,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            if done.returncode:
                print(f"  it failed, and has no picture: {done.stderr[-500:]}")
            else:
                draw(f"{folder}/run", picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
