"""The expected results of the decks in this folder: backward Euler with the increments that each deck asks for.

expected.py [DECK ...]    prints the table of README.md

In all four decks the fibre's stretch is prescribed, so G needs no finite elements; the sides follow from their
being free. This is written apart from the library's code, so that it can check it: no line is shared.
"""
import math
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "common"))
import files  # noqa: E402  shared by all examples

C1, C2, TAU, GAMMA, G_MAX, LAMBDA_CRIT = 16.0, 4.0, 0.5, 2.0, 1.1, 1.01  # Table 1: kPa and days
DECKS = ("cube_c3d8.inp", "plane_strain_cpe4.inp", "axisymmetric_cax4.inp", "shell_s4.inp")


def stretch(t):
    return 1 + 0.1 * min(t, 1.0)


def times(deck):
    """Ends of the increments of a deck whose first increment in every step is also its longest."""
    result = [0.0]
    for line in re.findall(r"^\*STATIC\n(.+)$", files.read_text(deck), re.M | re.I):
        try:
            first, total, _, longest = (float(x) for x in line.split(","))
        except ValueError:
            first = longest = math.nan
        if not first == longest > 0:
            raise files.FileError(f"{deck}: {files.shown(line)}: expected a first increment > 0 that is also the longest")
        n, start = round(total / first), result[-1]
        result += [start + total * i / n for i in range(1, n + 1)]
    return result


def root(f, a, b):
    """The root of f between a and b, by bisection: f(a) <= 0 <= f(b)."""
    while True:
        middle = (a + b) / 2
        if not a < middle < b:
            return middle
        a, b = (middle, b) if f(middle) < 0 else (a, middle)


def grow(G_n, lam, dt):
    """G after a step of backward Euler."""

    def residual(G):
        return G - G_n - dt / TAU * ((G_MAX - G) / (G_MAX - 1)) ** GAMMA * (lam / G - LAMBDA_CRIT)

    return G_n if lam <= LAMBDA_CRIT * G_n else root(residual, G_n, min(G_MAX, lam / LAMBDA_CRIT))


def side(lam, G, free):
    """Stretch of the `free` sides (1 or 2) on which there is no stress."""
    return root(lambda a: C1 * math.log(lam * a**free / G) + C2 * (a * a - 1), 0.5, 1.5)


def history(deck):
    """Rows (time, G, lambda_e, side, s_fibre, s_held, reaction) of a deck."""
    name = pathlib.Path(deck).name
    if name not in DECKS:
        raise files.FileError(f"{deck}: expected one of {', '.join(DECKS)}")
    free = 1 if "cpe4" in name else 2
    rows, G = [], 1.0
    ends = times(deck)
    for before, t in zip([0.0] + ends, ends):
        lam = stretch(t)
        G = grow(G, lam, t - before)
        a = side(lam, G, free)
        J = lam * a**free
        pressure = C1 * math.log(J / G) / J
        s_fibre = pressure + C2 * ((lam / G) ** 2 - 1) / J
        area = a**free  # of a face that was 1 mm x 1 mm
        if "cax4" in name:
            area *= math.pi  # a circle of radius 1 mm
        elif "s4." in name:
            area = 10 * a  # 10 mm x 1 mm; the shell section keeps its thickness
        rows.append((t, G, lam / G, a, s_fibre, pressure if free == 1 else 0.0, s_fibre * area))
    return rows


def table(decks):
    lines = ["| deck | day | SDV1 = G | SDV2 = lambda_e | stress along the fibre [kPa] | reaction [mN] |",
             "|---|---|---|---|---|---|"]
    for deck in decks:
        at = {round(row[0], 6): row for row in history(deck)}
        for day in (1, 14, 42):
            if day not in at:
                raise files.FileError(f"{deck}: no increment ends on day {day}")
            _, G, lambda_e, _, s, _, reaction = at[day]
            lines.append(f"| `{pathlib.Path(deck).name}` | {day} | {G:.6f} | {lambda_e:.6f} | {s:.5f} | {reaction:.5f} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    with files.faults_in_one_line("expected.py"):
        print(table(sys.argv[1:] or [pathlib.Path(__file__).parent / d for d in DECKS]), end="")
