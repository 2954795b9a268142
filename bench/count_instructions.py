"""Counts the instructions per point, and fails if they have increased.

The figure is deterministic, unlike a time: callgrind's count in our own code, for growing points, as the difference of
two runs. The system's libraries are left out, because they choose their code by the processor. The figures in
instructions.json belong to one compiler and its flags; for another compiler there is nothing to compare with. For a
change that is meant to cost more, keep the new figures with --update.
"""
import argparse
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "examples/common"))
import files  # noqa: E402  shared by all Python programs

SKIP = 77
GROWTH_ALLOWED = 0.03
GAMMAS = ("2", "2.5")
SYSTEM = re.compile(r"/(ld-linux|libc|libm|libstdc\+\+|libgcc_s|vgpreload_core)[.-][^/]*$")


def arguments():
    p = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    p.add_argument("driver", type=pathlib.Path, help="the program `instructions`")
    p.add_argument("--update", action="store_true", help="keep what is counted now")
    p.add_argument("--figures", type=pathlib.Path, default=pathlib.Path(__file__).with_name("instructions.json"))
    return p.parse_args()


def own_instructions(callgrind_file):
    """The sum over our objects of callgrind's self costs."""
    names, ours, total, called = {}, True, 0, False
    for line in callgrind_file.read_text().splitlines():
        if line.startswith("ob="):
            number, name = re.fullmatch(r"ob=(\(\d+\)) ?(.*)", line).groups()
            names.setdefault(number, name)
            ours = not SYSTEM.search(names[number])
        elif line.startswith("calls="):
            called = True  # the next line is the callee's
        elif re.match(r"[\d+*-]", line):
            if not called and ours:
                total += int(line.split()[1])
            called = False
        elif m := re.match(r"cob=(\(\d+\)) (.+)", line):
            names.setdefault(*m.groups())
    return total


def count(driver, variant, gamma):
    """Instructions per point."""
    totals = []
    for passes in (1, 3):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "callgrind.out"
            run = subprocess.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", driver, variant, gamma,
                                  str(passes)], capture_output=True, text=True)
            if run.returncode:
                sys.exit(f"{driver} {variant} {gamma} {passes}:\n{run.stderr}")
            totals.append(own_instructions(out))
    return round((totals[1] - totals[0]) / (2 * int(run.stdout)))


def main():
    a = arguments()
    if not shutil.which("valgrind"):
        print("skipped: no valgrind")
        sys.exit(SKIP)
    kept = files.read_json(a.figures) if a.figures.exists() else {}
    key, *variants = subprocess.run([a.driver], capture_output=True, text=True, check=True).stdout.splitlines()
    if key not in kept and not a.update:
        print(f"skipped: no figures for {key!r}, only for {list(kept)}")
        sys.exit(SKIP)

    counted = {f"{variant}, gamma {gamma}": count(a.driver, variant, gamma) for variant in variants for gamma in GAMMAS}
    before = kept.get(key, {})
    grown = []
    print(f"{'instructions per point':40}{'kept':>8}{'now':>8}")
    for name, now in counted.items():
        was = before.get(name)
        bad = was is None or now > (1 + GROWTH_ALLOWED) * was
        print(f"{name:40}{was or '-':>8}{now:8}" + ("" if was is None else f"{100 * (now / was - 1):+8.1f} %"))
        if bad:
            grown.append(name)
    if a.update:
        kept[key] = counted
        files.write_json(a.figures, kept, indent=2)
    elif grown:
        sys.exit(f"FAILED: more than {100 * GROWTH_ALLOWED:g} % more instructions, or none kept: {'; '.join(grown)}.\n"
                 "If that is meant, keep the new figures: ./run instructions --update")
    elif any(counted.get(name, was) < (1 - GROWTH_ALLOWED) * was for name, was in before.items()):
        print("fewer than before: keep the new figures with ./run instructions --update")


if __name__ == "__main__":
    with files.faults_in_one_line("count_instructions.py"):
        main()
