"""Builds the site from the repository's own pages: Doxygen reads the headers, Sphinx makes one site from both.

build_site.py OUT [--python FOLDER]     FOLDER: where the Python module was built, for its reference

The page of web/ is in the site's folder law/ where its tools are; the pages are those of pages.txt, in the same folders for Sphinx as in the repository, so that links work in both.
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples/common"))
import files  # noqa: E402  shared by all Python programs

SITE = pathlib.Path(__file__).resolve().parent
ROOT = SITE.parents[1]
MATHJAX = pathlib.Path("/usr/share/javascript/mathjax")
NORMALIZE = pathlib.Path("/usr/share/javascript/normalize.css/normalize.css")
MATHJAX_PARTS = ("MathJax.js", "config/TeX-AMS_SVG.js", "extensions", "jax/element", "jax/input/TeX",
                 "jax/output/SVG/autoload", "jax/output/SVG/config.js", "jax/output/SVG/jax.js",
                 "jax/output/SVG/fonts/TeX", "jax/output/PreviewHTML")
LINK = re.compile(r"(\[[^\]]*\]\()([^)#\s]+)(#[^)\s]*)?\)")
CXX_INTRODUCTION = """# C++ headers

What each header is for: [manual](../docs/manual.md#the-c-headers). Names are in namespace `myogrowth`; `detail` is not for users.

"""


def listed():
    """Captions and the existing pages below them."""
    groups = []
    for line in (SITE / "pages.txt").read_text().splitlines()[1:]:
        if line.startswith("#"):
            groups.append((line[1:].strip(), []))
        elif line:
            groups[-1][1].append(line)
    return groups


def place_of(page):
    """The place in the site of a page of the repository: README.md is the front page."""
    return pathlib.PurePosixPath("index.md" if page == "README.md" else page)


# The page that computes: its place in the site, and how docs/web.md names the one that ./run web makes.
LAW, LAW_IN_TREE = "law/index.html", "`out/web/index.html`"


def build_law(html, work):
    """The page of web/ in the site; False if a tool for it is missing, which it has said."""
    run = subprocess.run([sys.executable, ROOT / "web/build.py", "--out", html / "law", "--objects", work / "web"])
    if run.returncode not in (0, 77):
        sys.exit(run.returncode)
    return run.returncode == 0


def lay_out(source, target, pages, with_law):
    """Copies a page and the pictures and files it links to; a link to a file of the repository becomes a download. A
    link to a folder leads to its README if that is a page; otherwise the link is removed."""
    text = (ROOT / source).read_text(encoding="utf-8")
    text = re.sub(r"^```math\n(.*?)^```$", r"$$\n\1$$", text, flags=re.S | re.M)  # the syntax of code hosts
    if with_law:
        link = os.path.relpath(LAW, place_of(source).parent)
        text = text.replace(LAW_IN_TREE, f'<a href="{link}">out/web/index.html</a>')
    here = pathlib.PurePosixPath(source).parent

    def relinked(match):
        opening, path, anchor = match.group(1), match.group(2), match.group(3) or ""
        if re.match(r"[a-z]+:", path):
            return match.group(0)
        file = os.path.normpath(str(here / path))
        if (ROOT / file).is_dir():
            if f"{file}/README.md" not in pages:
                return opening[1:-2]
            file += "/README.md"
        if file in pages:
            path = os.path.relpath(place_of(file), place_of(source).parent)
        elif file == "abi/myogrowth.h":
            path = os.path.relpath("api/c.md", place_of(source).parent)
        elif (ROOT / file).is_file():
            (target / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / file, target / file)
        else:
            sys.exit(f"{source}: link to {path}: there is no such file")
        return f"{opening}{path}{anchor})"

    place = target / place_of(source)
    place.parent.mkdir(parents=True, exist_ok=True)
    code = re.compile(r"(^```.*?^```|`[^`\n]*`)", re.S | re.M)
    parts = code.split(text)
    files.write_text(place, "".join(p if i % 2 else LINK.sub(relinked, p) for i, p in enumerate(parts)))


def doxygen(out):
    """XML of the public headers; fails where something public has no comment."""
    settings = (SITE / "Doxyfile").read_text() + f"OUTPUT_DIRECTORY = {out}\n"
    out.mkdir(parents=True, exist_ok=True)
    run = subprocess.run(["doxygen", "-"], input=settings, text=True, cwd=ROOT, stderr=subprocess.PIPE)
    if run.returncode != 0:
        sys.exit(f"{run.stderr}a public symbol needs a comment: what it is, shapes, unit, errors")
    for file in (out / "xml").glob("*.xml"):  # groups without a name are functions like others
        text = file.read_text(encoding="utf-8")
        files.write_text(file, text.replace('<sectiondef kind="user-defined">', '<sectiondef kind="func">'))
    return out / "xml"


def reference(target, with_python):
    """The pages of the API, header by header in the order of the manual's table."""
    (target / "api").mkdir()
    headers = sorted(str(p.relative_to(ROOT / "include/myogrowth")) for p in (ROOT / "include/myogrowth").rglob("*.hpp"))
    first = ["material.hpp", "kernel.hpp", "measures.hpp", "many/batch.hpp", "more/stress_states.hpp", "growth_rate.hpp",
             "growth_step.hpp", "growth_flow.hpp"]
    headers.sort(key=lambda name: first.index(name) if name in first else len(first))
    links = "".join(f"- [{name}]({name[:-4]}.md)\n" for name in headers)
    toc = "```{toctree}\n:hidden:\n" + "".join(name[:-4] + "\n" for name in headers) + "```\n"
    files.write_text(target / "api/cpp.md", CXX_INTRODUCTION + links + "\n" + toc)
    for name in headers:
        (target / "api" / name).parent.mkdir(exist_ok=True)
        files.write_text(target / "api" / f"{name[:-4]}.md", f"# {name}\n\n```{{doxygenfile}} {pathlib.Path(name).name}\n```\n")
    files.write_text(target / "api/c.md", "# C API\n\n`#include <myogrowth.h>`, `build/abi/libmyogrowth.so`; tables and "
                                     "examples: [manual](../docs/manual.md#the-c-api).\n\n"
                                     "```{doxygenfile} myogrowth.h\n```\n")
    if with_python:
        files.write_text(target / "api/python.md", "# Python module\n\n```{eval-rst}\n.. automodule:: myogrowth\n"
                                              "   :members:\n```\n")


def finish_theme(static):
    """Debian's furo needs a web server for a style sheet and for modules: browsers do not load modules from files."""
    shutil.copy(NORMALIZE, static / "styles")
    style = static / "styles/furo.css"
    files.write_text(style, style.read_text().replace("url(/javascript/normalize.css/normalize.css)", "url(normalize.css)"))
    scripts = static / "scripts"
    whole = (scripts / "gumshoe-patched.js").read_text() + (scripts / "furo.js").read_text()
    files.write_text(scripts / "furo.js", whole.replace('import Gumshoe from "./gumshoe-patched.js";', ""))


def main():
    p = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    p.add_argument("out", type=pathlib.Path)
    p.add_argument("--python", type=pathlib.Path)
    a = p.parse_args()
    work = ROOT / "build/docs"
    stage, html = work / "pages", files.make_folder(a.out.resolve())
    files.remove([html / "index.html"])
    shutil.rmtree(stage, ignore_errors=True)
    stage.mkdir(parents=True)
    xml = doxygen(work / "doxygen")
    reference(stage, a.python is not None)

    groups = [(caption, [page for page in pages if (ROOT / page).is_file() or (stage / page).is_file()])
              for caption, pages in listed()]
    with_law = build_law(html, work)
    pages = ["README.md"] + [page for _, group in groups for page in group if (ROOT / page).is_file()]
    for page in pages:
        lay_out(page, stage, pages, with_law)
    trees = [f"\n```{{toctree}}\n:hidden:\n:caption: {caption}\n" + "".join(f"{page[:-3]}\n" for page in group) + "```\n"
             for caption, group in groups if group]
    files.write_text(stage / "index.md", "".join([files.read_text(stage / "index.md"), *trees]))

    static = stage / "_static"
    static.mkdir()
    shutil.copy(SITE / "site.css", static)
    for part in MATHJAX_PARTS:
        source, target = MATHJAX / part, static / "mathjax" / part
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copytree(source, target) if source.is_dir() else shutil.copy(source, target)

    header = (ROOT / "include/myogrowth/version.hpp").read_text()
    environment = dict(os.environ, MYOGROWTH_DOXYGEN_XML=str(xml), MYOGROWTH_STATIC=str(static), MYOGROWTH_VERSION=".".join(
        re.search(rf"VERSION_{part} (\d+)", header).group(1) for part in ("MAJOR", "MINOR", "PATCH")))
    if a.python:
        environment["PYTHONPATH"] = str(a.python.resolve())
    subprocess.run([sys.executable, "-m", "sphinx", "-b", "html", "-q", "-W", "--keep-going", "-E", "-c", SITE,
                    "-d", work / "doctrees", stage, html], check=True, env=environment)
    finish_theme(html / "_static")
    print(html / "index.html")


if __name__ == "__main__":
    with files.faults_in_one_line("build_site.py"):
        main()
