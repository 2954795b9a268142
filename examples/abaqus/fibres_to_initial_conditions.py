"""Makes the *INITIAL CONDITIONS, TYPE=SOLUTION block of a fibre field, for an Abaqus deck to *INCLUDE.

fibres_to_initial_conditions.py FIBRES.csv [--depvar 8|9] [-o BLOCK.inp]

The field is a table with the header element,n1,n2,n3 and a row for each element: its label and its fibre direction in
the reference configuration, of any length > 0. Blank lines and text after # are ignored.
"""
import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "common"))
import files  # noqa: E402  shared by all examples

HEADER = ["element", "n1", "n2", "n3"]


def read(path):
    """{element: direction as it is written} in the order of the file; errors name the line and what was expected."""
    fibres, lines = {}, {}
    for line, (label, *direction) in files.rows(path, HEADER):
        if not (label.isdecimal() and label.isascii() and int(label) > 0):
            raise files.FileError(f"{path}:{line}: element {files.shown(label)}: expected a whole number > 0")
        element = int(label)
        if element in fibres:
            raise files.FileError(f"{path}:{line}: element {element}: given already in line {lines[element]}")
        if not any([files.finite(path, line, *field) for field in zip(HEADER[1:], direction)]):
            raise files.FileError(f"{path}:{line}: n1, n2, n3 = 0, 0, 0: expected a direction, of any length > 0")
        fibres[element], lines[element] = direction, line
    return fibres


def block(fibres, depvar):
    """Abaqus takes the element and at most seven values on the first line, and at most eight on each further line."""
    lines = ["*INITIAL CONDITIONS, TYPE=SOLUTION"]
    for element, direction in fibres.items():
        # G = 0 is taken as 1, "nothing grown yet"; the next four and STATEV(9) are results.
        values = ["0."] * 5 + direction + ["0."] * (depvar - 8)
        lines.append(", ".join([str(element), *values[:7]]))
        lines += [", ".join(values[i : i + 8]) for i in range(7, len(values), 8)]
    return "\n".join(lines) + "\n"


def main():
    title, _, table = __doc__.split("\n\n")
    p = argparse.ArgumentParser(description=title, epilog=table)
    p.add_argument("fibres", metavar="FIBRES.csv")
    p.add_argument("--depvar", type=int, choices=(8, 9), default=8,
                   help="what the deck's *DEPVAR says: 8, or 9 for plane stress, membranes and shells")
    p.add_argument("-o", "--output", metavar="BLOCK.inp", help="file to write (default: standard output)")
    a = p.parse_args()
    with files.faults_in_one_line("fibres_to_initial_conditions.py"):
        files.write_text_or_print(a.output, block(read(a.fibres), a.depvar), encoding="ascii", source=a.fibres)


if __name__ == "__main__":
    main()
