"""Writes src/presets.js: parameters of published and made-up studies, as ./run fit finds them.

presets.py STUDY_FIT [--check]     --check: compares with the file that is there (1e-4, relative), and writes nothing
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "examples/common"))
import files  # noqa: E402  shared by all Python programs

IDENTIFICATION = ROOT / "examples/identification"
STUDIES = ["example.csv", "published/zollner_2012.csv", "published/boakes_2007.csv", "published/tabary_1972_lengthened.csv",
           "published/tabary_1972_shortened.csv", "published/csapo_2010.csv"]
GROWTH = ("tau", "gamma", "G_max", "lambda_crit")
TARGET = ROOT / "web/src/presets.js"
HEAD = """// Written by web/presets.py from ./run fit: do not edit. fitted: what the measurements decide; the rest is set in the file.
// set: removal, where the study has it.
export const PRESETS = """


def preset(program, name):
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, IDENTIFICATION / name, "--out", folder], check=True, stdout=subprocess.DEVNULL)
        report = files.read_json(pathlib.Path(folder) / "report.json")
    text = files.read_text(IDENTIFICATION / name)
    source = re.sub(r"\s*\n#\s*", " ", re.match(r"# (.*(?:\n# .*)*)", text).group(1)).split(". From the abstract")[0].split(" (./run")[0]
    given = {key: float(value) for key, value in re.findall(r"^set, (\w+), (\S+)", text, re.M) if key not in GROWTH}
    growth = {key: float(f"{value:.5g}") for key, value in zip(GROWTH, report["values"])}
    return {"id": pathlib.Path(name).stem, "title": report["title"], "source": f"{source.rstrip('.')}. "
            f"File: examples/identification/{name}", "fitted": [p["name"] for p in report["parameters"]],
            "values": {**growth, **given}}


def main():
    program, check = pathlib.Path(sys.argv[1]), sys.argv[2:] == ["--check"]
    found = [{"id": "paper", "title": "the paper, Table 1", "fitted": [], "source": "Javadi et al., Simulation of Biceps "
              "Femoris Muscle Growth Based on Stretch Using a Multiscale Model, Table 1",
              "values": {"tau": 0.5, "gamma": 2, "G_max": 1.1, "lambda_crit": 1.01}}]
    found += [preset(program, name) for name in STUDIES]
    if not check:
        files.write_text(TARGET, HEAD + json.dumps(found, indent=2, ensure_ascii=False) + ";\n")
        return
    kept = json.loads(files.read_text(TARGET).split("PRESETS = ")[1].rstrip().rstrip(";"))
    for a, b in zip(kept, found):
        same = {**a, "values": 0} == {**b, "values": 0} and a["values"].keys() == b["values"].keys() and all(
            abs(a["values"][k] - x) <= 1e-4 * abs(x) for k, x in b["values"].items())
        if not same:
            raise files.FileError(f"{TARGET.relative_to(ROOT)}: {a['id']} is not what ./run fit finds now: write it again "
                                  f"(web/presets.py build/examples/study_fit)\n{a}\n{b}")
    if len(kept) != len(found):
        raise files.FileError(f"{TARGET.relative_to(ROOT)}: {len(kept)} presets, expected {len(found)}")
    print(f"{len(kept)} presets are those of ./run fit")


if __name__ == "__main__":
    with files.faults_in_one_line("web/presets.py"):
        main()
