"""Draws the curves of docs/laws.md from what the program law_curves prints.

law_curves.py PROGRAM FOLDER
"""
import collections
import csv
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples/common"))
import files  # noqa: E402
import pictures  # noqa: E402
from pictures import BLUE, GREEN, ORANGE, plt  # noqa: E402


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__.split("\n\n")[1].strip())
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    text = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    curves = collections.defaultdict(dict)  # (law, G, activation): {stretch: stress}
    for row in csv.DictReader(text.splitlines()):
        curves[row["law"], row["G"], float(row["activation"])][float(row["stretch"])] = float(row["stress"])
    plt.rcParams.update(pictures.GRID)

    fig, axes = plt.subplots(2, 2, figsize=(8, 6), layout="constrained")
    highest = {"Roehrle": 350, "Blemker": 350, "Ehret": 150}
    for ax, (law, title) in zip(axes.flat, {"neo-Hookean": "law 0, neo-Hookean (c1 = 16, c2 = 4 kPa)",
                                            "Roehrle": "law 1, Röhrle", "Blemker": "law 2, Blemker, muscle",
                                            "Ehret": "law 3, Ehret and Weickenmeier (kappa = 1e4)"}.items()):
        passive, total = curves[law, "1.000000", 0], curves[law, "1.000000", 1]
        ax.plot(passive.keys(), passive.values(), color=BLUE, label="passive")
        if total:
            both = [x for x in total if x in passive]
            ax.plot(both, [total[x] - passive[x] for x in both], color=ORANGE, ls="--", label="active: the difference")
            ax.plot(total.keys(), total.values(), color=GREEN, label="total, activation 1")
            ax.set_ylim(-0.2 * highest[law], highest[law])
            published = curves.get((f"{law} kappa 100", "1.000000", 1))
            if published:
                ax.plot(published.keys(), published.values(), color="0.5", ls=":", label="total, published kappa = 100")
        ax.set(title=title, xlabel="stretch of the strip [-]", ylabel="force per reference area [kPa]")
        ax.legend()
    pictures.save(fig, folder / "law_curves.png")

    fig, ax = plt.subplots(figsize=(6.4, 4), layout="constrained")
    for colour, G in zip((BLUE, ORANGE), sorted({G for law, G, _ in curves if law == "whole muscle"})):
        passive, total = curves["whole muscle", G, 0], curves["whole muscle", G, 1]
        both = [x for x in total if x in passive]
        label = "before" if float(G) == 1 else f"after six weeks, G = {float(G):.4f}"
        ax.plot(both, [total[x] - passive[x] for x in both], color=colour, label=f"active, {label}")
        ax.plot(both, [passive[x] for x in both], color=colour, ls=":", label=f"passive, {label}")
    ax.set(xlabel="stretch of the muscle, relative to its first length [-]", ylabel="force per reference area [kPa]",
           ylim=(-20, 400))
    ax.legend()
    pictures.save(fig, folder / "law_force_length.png")


if __name__ == "__main__":
    with files.faults_in_one_line("law_curves.py", ImportError, ValueError, subprocess.CalledProcessError):
        main()
