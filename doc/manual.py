#!/usr/bin/env python3
"""Make the pages of the manual, which doxygen then turns into HTML.

    doc/manual.py SOURCE_ROOT FOLDER     # pages and pictures into FOLDER
    doc/manual.py --header FILE.h        # a header as doxygen should read it
    cmake --build build --target doc     # does that, and calls doxygen

Pages are the Markdown files of the project as they are, in the order below,
the tutorials with their programs woven in, a gallery of the scenes in
prm/examples and prm/ground, and the reference of parameters. Doxygen wants
other signs for formulas, links and anchors than GitHub: they are changed here,
so that one text serves both.
"""
import os
import re
import shutil
import sys

# the order of the manual: part, pages
PARTS = [
    ("Begin here", ["doc/first-day.md", "doc/user-guide.md", "GALLERY"]),
    ("Describe a scene", ["doc/geometry.md", "doc/materials.md", "doc/contact.md", "doc/tools.md",
                          "doc/ground.md", "doc/static.md", "doc/restart.md", "doc/study.md",
                          "PARAMETERS"]),
    ("Read results", ["doc/output.md", "doc/ledger.md", "doc/timing.md"]),
    ("Theory", ["doc/method.md", "doc/locking.md"]),
    ("How good, how fast", ["doc/accuracy-and-cost.md", "doc/stability.md", "doc/taylor-bar.md",
                            "doc/performance.md", "doc/scaling.md"]),
    ("Write programs", ["doc/tutorials/README.md"] +
     [f"doc/tutorials/step-{n}/README.md" for n in range(1, 9)] +
     ["doc/extending.md", "doc/architecture.md", "doc/dependencies.md", "CONTRIBUTING.md"]),
]
GALLERY_FOLDERS = ["prm/examples", "prm/ground"]


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def page_id(path):
    """A name for doxygen."""
    return "page_" + re.sub(r"\W+", "_", path.removeprefix("doc/").removesuffix(".md")).strip("_").lower()


def slug(heading):
    """The anchor that GitHub gives a heading."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def unique(name, used):
    """As GitHub does: the second one is name-1."""
    n, result = 0, name
    while result in used:
        n += 1
        result = f"{name}-{n}"
    used.add(result)
    return result


def outside_code(text, change):
    """Change what stands neither in fences, nor in indented blocks, nor in `code`."""
    lines, in_fence, result = text.split("\n"), False, []
    for line in lines:
        if line.lstrip().startswith("```"):
            in_fence = not in_fence
            line = re.sub(r"^(\s*```)(\w+) .*$", r"\1\2", line)  # ```cpp FILE
        elif not in_fence and not line.startswith("    "):
            line = "".join(part if i % 2 else change(part) for i, part in enumerate(re.split(r"(`[^`]*`)", line)))
        result.append(line)
    return "\n".join(result)


class Manual:
    def __init__(self, root, folder):
        self.root, self.folder = root, folder
        self.pages = [page for _, pages in PARTS for page in pages]
        self.ids = {"README.md": "index"}
        for page in self.pages:
            self.ids[page] = page_id(page)
        self.ids["doc/parameters.prm"] = self.ids["PARAMETERS"]

    def link(self, page, text, target):
        """A link of a page, for doxygen."""
        if re.match(r"[a-z]+://", target):
            return f"[{text}]({target})"
        path, _, anchor = target.partition("#")
        full = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
        if os.path.isdir(os.path.join(self.root, full)):
            full = os.path.join(full, "README.md")
        if full in self.ids:
            own = self.ids[full]
            return f"[{text}](@ref {own + '_' + anchor if anchor else own})"
        text = text.strip("`")
        return f"`{text}`" if text == full or text in full else f"{text} (`{full}`)"

    def picture(self, page, text, target):
        full = os.path.normpath(os.path.join(os.path.dirname(page), target))
        name = full.replace("/", "-").removeprefix("doc-pictures-")
        if not os.path.exists(os.path.join(self.root, full)):
            sys.exit(f"{page}: there is no picture {full}")
        shutil.copy(os.path.join(self.root, full), os.path.join(self.folder, "pictures", name))
        return f"![{text}]({name})"

    def convert(self, page, text):
        """GitHub's Markdown as doxygen's."""
        own = self.ids[page]

        def signs(part):
            part = re.sub(r"\$\$(.+?)\$\$", r"\\f[\1\\f]", part)
            part = re.sub(r"(?<![\\\w])\$([^$]+?)\$", r"\\f$\1\\f$", part)
            part = re.sub(r"@(?=\w)(?!ref)", r"\\@", part)
            return part

        def links(part):
            part = re.sub(r"!\[([^\]]*)\]\(([^)]+)\)", lambda m: self.picture(page, m[1], m[2]), part)
            return re.sub(r"(?<!!)\[([^\]]+)\]\(([^)@]+)\)", lambda m: self.link(page, m[1], m[2]), part)

        # formulas over several lines, then all else line by line
        pieces = re.split(r"(\$\$.+?\$\$)", text, flags=re.S)
        text = "".join(re.sub(r"^\$\$(.+)\$\$$", lambda m: "\\f[" + m[1] + "\\f]", piece, flags=re.S)
                       if i % 2 else piece for i, piece in enumerate(pieces))
        # links may have `code` in their texts: before code is set aside
        in_fence, lines = False, []
        for line in text.split("\n"):
            if line.startswith("```"):
                in_fence = not in_fence
            lines.append(line if in_fence or line.startswith("    ") else links(line))
        text = outside_code("\n".join(lines), signs)

        in_fence, lines, first, used = False, [], True, set()
        for line in text.split("\n"):
            if line.startswith("```"):
                in_fence = not in_fence
            heading = None if in_fence else re.match(r"(#+) (.*)", line)
            if heading and first:
                line, first = f"# {heading[2]} {{#{own}}}", False
            elif heading:
                name = unique(slug(heading[2]), used)
                line = f"{heading[1]} {heading[2]} {{#{own}_{name}}}"
            lines.append(line)
        return "\n".join(lines) + "\n"

    def write(self, page, text):
        with open(os.path.join(self.folder, self.ids[page] + ".md"), "w", encoding="utf-8") as file:
            file.write(self.convert(page, text))

    def tutorial(self, page):
        """Its text, with the program where it is linked."""
        text = read(os.path.join(self.root, page))
        step = os.path.basename(os.path.dirname(page))
        program = read(os.path.join(self.root, os.path.dirname(page), step + ".cc"))
        words = woven(program)
        return re.sub(r"## The commented program\n.*?(?=\n## )",
                      lambda _: "## The commented program\n\n" + words +
                      "\n## The plain program\n\n```cpp\n" + uncommented(program) + "```\n", text, flags=re.S)

    def make(self):
        shutil.rmtree(self.folder, ignore_errors=True)
        os.makedirs(os.path.join(self.folder, "pictures"))
        for page in self.pages:
            if page == "GALLERY":
                self.write(page, gallery(self.root))
            elif page == "PARAMETERS":
                self.write(page, "# All parameters\n\n```\n" +
                           read(os.path.join(self.root, "doc/parameters.prm")) + "```\n\n# Of studies\n\n```\n" +
                           read(os.path.join(self.root, "doc/study.prm")) + "```\n")
            elif "/step-" in page:
                self.write(page, self.tutorial(page))
            else:
                self.write(page, read(os.path.join(self.root, page)))
        text = self.convert("README.md", read(os.path.join(self.root, "README.md")))
        text = text.replace("# emmy {#index}", "# emmy {#mainpage}", 1)
        contents = "\n## The pages of this manual\n\n"
        for part, pages in PARTS:
            contents += f"{part}:\n" + "".join(f"- \\subpage {self.ids[page]}\n" for page in pages) + "\n"
        with open(os.path.join(self.folder, "index.md"), "w", encoding="utf-8") as file:
            file.write(text + contents)


def woven(program):
    """Comments become text, the lines between them code."""
    result, code = [], []

    def flush():
        while code and not code[0].strip():
            code.pop(0)
        while code and not code[-1].strip():
            code.pop()
        if code:
            result.extend(["", "```cpp", *code, "```", ""])
        code.clear()

    for line in program.split("\n"):
        comment = re.match(r"\s*// ?(.*)", line)
        if comment:
            flush()
            result.append(comment[1])
        else:
            code.append(line)
    flush()
    return "\n".join(result) + "\n"


def uncommented(program):
    text = "\n".join(line for line in program.split("\n") if not re.match(r"\s*//", line))
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


# <Model> in a comment is a word of a parameter file, no tag
WORD_IN_BRACKETS = re.compile(r"(?<![\w<\\])<([A-Za-z][\w' ]*)>")
DECLARATION = re.compile(r"( *)((?:(?:static|constexpr|const|mutable|unsigned) )*[\w:]+(?:<[^;=]*>)? +(?:const )?)(\*?\w[^()]*,[^()]*);$")


def split_at_commas(text):
    parts, depth = [""], 0
    for letter in text:
        depth += (letter in "<[{(") - (letter in ">]})")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts]


def header(text):
    """For doxygen: words in brackets are no tags, and what is said of <int a, b;> is said of both.
    Lines keep their numbers."""
    lines = text.split("\n")
    for i, line in enumerate(lines):
        code, mark, words = line.partition("//")
        if mark or re.match(r"\s*(/\*\*| \*)", line):
            start = 0 if not mark else len(code)
            lines[i] = line = line[:start] + WORD_IN_BRACKETS.sub(r"\<\1\>", line[start:])
        after = re.match(r"(.*;)\s*///< (.*)", line)
        code = (after[1] if after else line).rstrip()
        k = i
        while code.endswith(",") and k + 1 < len(lines): # goes on in the next line
            k += 1
            code += " " + lines[k].strip()
        found = DECLARATION.match(code)
        comment = after[2] if after else comment_before(lines, i)
        if found and comment:
            names = split_at_commas(found[3])
            lines[i] = found[1] + " ".join(
                ("" if n == 0 and not after else f"/** {comment} */ ") + found[2] + name + ";" for n, name in enumerate(names))
            lines[i + 1:k + 1] = [""] * (k - i)
    return "\n".join(lines)


def comment_before(lines, i):
    """The words of the comment that ends in the line above; empty: none."""
    k = i - 1
    if k < 0 or not lines[k].rstrip().endswith("*/"):
        return ""
    while k > 0 and "/**" not in lines[k]:
        k -= 1
    return " ".join(re.sub(r"^\s*(/\*\*|\*/|\*)|\*/\s*$", "", line).strip() for line in lines[k:i]).strip()


def head_of(scene):
    """The comment at the start of a scene by its keys; '' is what stands first."""
    words, key = {"": ""}, ""
    for line in scene.split("\n"):
        if not line.startswith("#"):
            break
        line = line[1:].strip()
        start = re.match(r"(Source|Expected|Run time|Ranks): *(.*)", line)
        if start:
            key, line = start[1], start[2]
        words[key] = (words.get(key, "") + " " + line).strip()
    return words


def scenes_of_gallery(root):
    """Those that are there; no studies."""
    scenes = [os.path.join(root, folder, name) for folder in GALLERY_FOLDERS
              for name in sorted(os.listdir(os.path.join(root, folder))) if name.endswith(".prm")]
    return [scene for scene in scenes if not re.search(r"^subsection Study", read(scene), re.M)]


def gallery(root):
    """A page of all scenes that are there, with pictures where these are."""
    text = ("# Gallery: what emmy can do\n\nThe scenes of `prm/examples` and `prm/ground`, as they are in their files. "
            "Run one with `./run prm/examples/NAME.prm`, or copy it. `doc/gallery.py build/emmy` draws the pictures.\n")
    for path in scenes_of_gallery(root):
        folder, name = os.path.split(os.path.relpath(path, root))
        name, scene = name.removesuffix(".prm"), read(path)
        title = re.search(r"^\s*set Title\s*=\s*(.*)$", scene, re.M)
        words = head_of(scene)
        text += f"\n## {title[1] if title else name}\n\n`{folder}/{name}.prm`. {words['']}\n"
        picture = f"doc/pictures/gallery/{os.path.basename(folder)}-{name}.png"
        if os.path.exists(os.path.join(root, picture)):
            text += f"\n![{folder}/{name}.prm]({picture})\n"
        for key, label in [("Expected", "What to look at"), ("Run time", "Run time"), ("Source", "Source")]:
            if words.get(key):
                text += f"\n{label}: {words[key]}\n"
    return text


if __name__ == "__main__":
    if sys.argv[1:2] == ["--header"]:
        print(header(read(sys.argv[2])), end="")
        sys.exit()
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    Manual(sys.argv[1], sys.argv[2]).make()
