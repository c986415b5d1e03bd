#!/usr/bin/env python3
"""All pages hang together: links, anchors, pictures and files that pages name
are there; all pages are in the manual; every picture is on a page.

    pages.py SOURCE_ROOT
"""
import os
import re
import sys

sys.dont_write_bytecode = True
root = os.path.abspath(sys.argv[1])
sys.path.insert(0, os.path.join(root, "doc"))
import manual  # noqa: E402

wrong, n_links, shown = [], 0, set()


def pages():
    for folder, folders, files in os.walk(root):
        folders[:] = [f for f in folders if not f.startswith((".", "build")) and f not in ("results", "_CPack_Packages")]
        for name in files:
            if name.endswith(".md"):
                yield os.path.relpath(os.path.join(folder, name), root)


def without_code(text):
    text = re.sub(r"^```.*?^```$", "", text, flags=re.S | re.M)
    return "\n".join(line for line in text.split("\n") if not line.startswith("    "))


def anchors(text):
    return {manual.slug(heading) for heading in re.findall(r"^#+ (.*)$", without_code(text), re.M)}


texts = {page: manual.read(os.path.join(root, page)) for page in pages()}
for page, text in texts.items():
    for picture, target in re.findall(r"(!?)\[(?:[^\]]*)\]\(([^)\s]+)\)", without_code(text)):
        if re.match(r"[a-z]+:", target):
            continue
        n_links += 1
        path, _, anchor = target.partition("#")
        full = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
        if not os.path.exists(os.path.join(root, full)):
            wrong.append(f"{page}: there is no <{target}>")
        elif anchor and full in texts and anchor not in anchors(texts[full]):
            wrong.append(f"{page}: <{full}> has no heading <{anchor}>")
        if picture:
            shown.add(full)
    # formulas: doxygen and its page want those within a line whole
    for line in re.sub(r"\$\$.*?\$\$|`[^`\n]*`", "", without_code(text), flags=re.S).split("\n"):
        if line.count("$") % 2:
            wrong.append(f"{page}: a formula goes on in the next line: <{line}>")
    # files that a page names
    for name in re.findall(r"`((?:prm|doc|source|include|tests)/[\w./-]+\.\w+)`", text):
        if not os.path.exists(os.path.join(root, name)) and not re.search(r"(?i)/layer/", name):
            wrong.append(f"{page}: there is no file <{name}>")

    # scenes that a command names; capitals and own names stand for the reader's
    for command in re.findall(r"^    (?:\$ )?((?:\./run|emmy|mpirun|build\S*/\S+|sbatch|cp) .*)$", text, re.M):
        for name in re.findall(r"(?<![\w/=.-])((?:prm|doc)/[\w./-]+\.(?:prm|sh))", command):
            n_links += 1
            if not os.path.exists(os.path.join(root, name)):
                wrong.append(f"{page}: the command <{command}> names no file <{name}>")

in_manual = set(manual.Manual(root, "").pages) | {"README.md"}
for page in texts:
    if page not in in_manual:
        wrong.append(f"{page}: it is not in the manual; add it to PARTS of doc/manual.py")
for folder, _, files in os.walk(os.path.join(root, "doc/pictures")):
    for name in files:
        full = os.path.relpath(os.path.join(folder, name), root)
        if full not in shown and "/gallery/" not in full:
            wrong.append(f"{full}: no page shows it")

for line in wrong:
    print(line)
print(f"{len(texts)} pages, {n_links} links, {len(shown)} pictures, {len(wrong)} wrong")
sys.exit(1 if wrong else 0)
