"""Compares the manual's tables of PROPS and STATEV with those that the UMAT itself prints.

check_manual.py [--write] MANUAL PRINT_TABLES
"""
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples/common"))
import files  # noqa: E402  shared by all Python programs

BEGIN, END = "<!-- tables: ./run tables -->\n", "<!-- end of tables -->\n"


def main():
    write = "--write" in sys.argv
    given = [a for a in sys.argv[1:] if a != "--write"]
    if len(given) != 2:
        sys.exit("usage: check_manual.py [--write] MANUAL PRINT_TABLES")
    path, printer = given
    tables = subprocess.run([printer], check=True, capture_output=True, text=True).stdout
    manual = files.read_text(path)
    found = re.search(re.escape(BEGIN) + "(.*?)" + re.escape(END), manual, re.S)
    if not found:
        sys.exit(f"{path}: no section between '{BEGIN.strip()}' and '{END.strip()}'")
    if write:
        files.write_text(path, manual[: found.start(1)] + tables + manual[found.end(1):])
    elif found.group(1) != tables:
        sys.exit(f"{path}: its tables differ from the code's; write them again with ./run tables")


if __name__ == "__main__":
    with files.faults_in_one_line("check_manual.py"):
        main()
