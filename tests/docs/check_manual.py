"""Compares the manual's tables of PROPS and STATEV with those that the UMAT itself prints.

check_manual.py [--write] MANUAL PRINT_TABLES
"""
import re
import subprocess
import sys

BEGIN, END = "<!-- tables: ./run tables -->\n", "<!-- end of tables -->\n"


def main():
    write = "--write" in sys.argv
    path, printer = [a for a in sys.argv[1:] if a != "--write"]
    tables = subprocess.run([printer], check=True, capture_output=True, text=True).stdout
    with open(path, encoding="utf-8") as f:
        manual = f.read()
    found = re.search(re.escape(BEGIN) + "(.*?)" + re.escape(END), manual, re.S)
    if not found:
        sys.exit(f"{path}: no section between '{BEGIN.strip()}' and '{END.strip()}'")
    if write:
        with open(path, "w", encoding="utf-8") as f:
            f.write(manual[: found.start(1)] + tables + manual[found.end(1):])
    elif found.group(1) != tables:
        sys.exit(f"{path}: its tables differ from the code's; write them again with ./run tables")


main()
