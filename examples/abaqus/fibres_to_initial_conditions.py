"""Makes the *INITIAL CONDITIONS, TYPE=SOLUTION block of a fibre field, for an Abaqus deck to *INCLUDE.

fibres_to_initial_conditions.py FIBRES.csv [--depvar 8|9] [-o BLOCK.inp]

The field is a table with the header element,n1,n2,n3 and a row for each element: its label and its fibre direction in
the reference configuration, of any length > 0. Blank lines and text after # are ignored.
"""
import argparse
import csv
import math
import sys

HEADER = ["element", "n1", "n2", "n3"]


def read(path):
    """{element: direction as it is written} in the order of the file; errors name the line and what was expected."""
    fibres, lines, headed = {}, {}, False
    with open(path, encoding="utf-8", newline="") as f:
        rows = csv.reader(line.split("#")[0] for line in f)
        for number, row in enumerate(rows, 1):
            row = [field.strip() for field in row]
            where = f"{path}:{number}: "
            if not any(row):
                continue
            if not headed:
                if row != HEADER:
                    raise ValueError(f"{where}'{','.join(row)}': expected the header {','.join(HEADER)}")
                headed = True
                continue
            if len(row) != 4:
                raise ValueError(f"{where}{len(row)} values: expected 4, {', '.join(HEADER)}")
            label, direction = row[0], row[1:]
            if not (label.isdecimal() and label.isascii() and int(label) > 0):
                raise ValueError(f"{where}element '{label}': expected a whole number > 0")
            element = int(label)
            if element in fibres:
                raise ValueError(f"{where}element {element}: given already in line {lines[element]}")
            for name, text in zip(HEADER[1:], direction):
                try:
                    ok = math.isfinite(float(text)) and "_" not in text
                except ValueError:
                    ok = False
                if not ok:
                    raise ValueError(f"{where}{name} = '{text}': expected a finite number")
            if not any(float(text) for text in direction):
                raise ValueError(f"{where}n1, n2, n3 = 0, 0, 0: expected a direction, of any length > 0")
            fibres[element], lines[element] = direction, number
    if not fibres:
        raise ValueError(f"{path}: expected {'rows below the header' if headed else 'the header ' + ','.join(HEADER)}")
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
    try:
        text = block(read(a.fibres), a.depvar)
    except (OSError, ValueError) as error:  # UnicodeDecodeError is a ValueError
        sys.exit(f"fibres_to_initial_conditions.py: {error}")
    if a.output:
        with open(a.output, "w", encoding="ascii", newline="\n") as f:
            f.write(text)
    else:
        sys.stdout.write(text)


if __name__ == "__main__":
    main()
