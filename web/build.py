"""Builds the page: the law of abi/'s C API as WebAssembly, the modules of src/, all in one file without a network.

build.py [--out FOLDER] [--objects FOLDER] [--picture FILE.png]     default: out/web, and build/web for object files

--picture: also takes a picture of the page, by a headless Chromium.

The first folder gets index.html and the licences. Status 77: a tool is missing, and it is named.
"""
import argparse
import base64
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "examples/common"))
import files  # noqa: E402  shared by all Python programs

WEB = ROOT / "web"
MOST_BYTES = 1_000_000
SKIPPED = 77  # ctest's
# Without -msimd128: clang 14 then leaves a term out of the stress (tests/web holds all numbers to the native library).
FLAGS = ["--target=wasm32-wasi", "-O2", "-std=c++17", "-fno-exceptions", "-fno-rtti", "-ffp-contract=off", "-Wall",
         "-Wextra", "-Werror", f"-I{ROOT / 'include'}", f"-I{ROOT / 'abi'}"]
LINK = ["--target=wasm32-wasi", "-mexec-model=reactor", "-nostdlib++", "-Wl,--gc-sections", "-Wl,--strip-all",
        "-Wl,-z,stack-size=262144"]


def missing_tools():
    """What is not there, with Debian's packages."""
    tools = {"clang++": "clang", "wasm-ld": "lld", "esbuild": "esbuild"}
    missing = [f"{tool} ({package})" for tool, package in tools.items() if not shutil.which(tool)]
    parts = {"/usr/include/wasm32-wasi/stdio.h": "wasi-libc", "/usr/include/wasm32-wasi/c++/v1/cmath": "libc++-dev-wasm32"}
    missing += [f"{part} ({package})" for part, package in parts.items() if not os.path.exists(part)]
    if "clang++ (clang)" not in missing:
        builtins = subprocess.run(["clang++", "--target=wasm32-wasi", "-print-libgcc-file-name"], text=True,
                                  capture_output=True).stdout.strip()
        if not os.path.exists(builtins):
            missing.append("compiler-rt for wasm32 (libclang-rt-dev-wasm32)")
    return missing


def c_api():
    """The sources of the C API as abi/CMakeLists.txt lists them, and the functions that its header declares."""
    text = files.read_text(ROOT / "abi/CMakeLists.txt")
    first = re.search(r"myogrowth_host_library\(myogrowth_c (\S+)", text)
    more = re.search(r"target_sources\(myogrowth_c PRIVATE ([^)$]*)", text)
    if not first or not more:
        raise files.FileError("abi/CMakeLists.txt: expected myogrowth_host_library(myogrowth_c ...) and its target_sources")
    header = files.read_text(ROOT / "abi/myogrowth.h")
    functions = sorted(set(re.findall(r"^[^/*\n].*\b(myogrowth_[a-z_]+)\(", header, re.M)))
    return [ROOT / "abi" / name for name in [first.group(1), *more.group(1).split(), "block.cpp"]], functions


def compile_law(objects):
    """The law as bytes of WebAssembly."""
    compiler = ["ccache", "clang++"] if shutil.which("ccache") else ["clang++"]
    sources, functions = c_api()
    made = []
    for source in [*sources, WEB / "ride.cpp"]:
        # As the function myogrowth_block of abi/CMakeLists.txt; small, since the page takes point after point.
        block = ["-Os", "-Dmyogrowth=myogrowth_base", "-DMYOGROWTH_UPDATE_BLOCK=myogrowth_update_block_base"]
        made.append(objects / f"{source.stem}.o")
        run([*compiler, *FLAGS, *(block if source.stem == "block" else []), "-c", source, "-o", made[-1]])
    exports = [f"-Wl,--export={name}" for name in [*functions, "ride_G", "ride_day", "malloc", "free"]]
    run(["clang++", *LINK, *exports, *made, "-o", objects / "law.wasm"])
    return (objects / "law.wasm").read_bytes()


def run(command):
    done = subprocess.run(command, text=True, capture_output=True, cwd=ROOT)
    if done.returncode != 0:
        raise files.FileError(f"{command[0]} {files.ended(done.returncode)}:\n{done.stderr.strip()}")
    return done.stdout


def take_picture(page, target):
    """The page as it opens. Virtual time runs until the band is drawn."""
    browser = shutil.which("chromium")
    if not browser:
        raise files.FileError("--picture: needs chromium, which is not here")
    with tempfile.TemporaryDirectory() as folder, files.writing(target) as part:
        made = pathlib.Path(folder) / "picture.png"
        run([browser, "--headless", "--disable-gpu", *(["--no-sandbox"] if os.geteuid() == 0 else []), "--hide-scrollbars",
             f"--user-data-dir={folder}/profile", f"--screenshot={made}", "--window-size=1280,1520",
             "--virtual-time-budget=5000", page.resolve().as_uri()])
        # A picture of 256 colours, to keep it small.
        from PIL import Image
        Image.open(made).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(part, "PNG", optimize=True)


def main():
    p = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    p.add_argument("--out", type=pathlib.Path, default=ROOT / "out/web")
    p.add_argument("--objects", type=pathlib.Path, default=ROOT / "build/web")
    p.add_argument("--picture", type=pathlib.Path, metavar="FILE.png")
    a = p.parse_args()
    if missing := missing_tools():
        print(f"web/build.py: not built, missing: {', '.join(missing)}", file=sys.stderr)
        sys.exit(SKIPPED)
    out, objects = files.make_folder(a.out), files.make_folder(a.objects.resolve())
    files.remove([out / "index.html"])
    example = files.read_text(ROOT / "examples/identification/example.csv")
    vendor = WEB / "vendor/uplot"
    parts = {
        "style": files.read_text(vendor / "uPlot.min.css") + files.read_text(WEB / "style.css"),
        "uplot": files.read_text(vendor / "uPlot.iife.min.js"),
        "law": f'window.MYOGROWTH_WASM = "{base64.b64encode(compile_law(objects)).decode()}";',
        "page": run(["esbuild", WEB / "src/main.js", "--bundle", "--format=iife", "--charset=utf8", "--target=es2019",
                     f"--define:EXAMPLE_CSV={json.dumps(example)}"]),
    }
    page = files.read_text(WEB / "page.html")
    for name, text in parts.items():
        page = page.replace("{{" + name + "}}", re.sub(r"</(?=script|style)", r"<\\/", text))
    files.write_text(out / "index.html", page)
    shutil.copy(ROOT / "LICENSE", out / "LICENSE")
    shutil.copy(vendor / "LICENSE", out / "LICENSE.uPlot")
    size = sum(path.stat().st_size for path in (out / "index.html", out / "LICENSE", out / "LICENSE.uPlot"))
    if size > MOST_BYTES:
        raise files.FileError(f"{out}: {size:,} bytes, expected at most {MOST_BYTES:,}")
    print(f"{out / 'index.html'}: {size:,} bytes with its two licences")
    if a.picture:
        take_picture(out / "index.html", a.picture)


if __name__ == "__main__":
    with files.faults_in_one_line("web/build.py"):
        main()
