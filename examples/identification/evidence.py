"""./run evidence: holds the law to all that is published, makes the tables and pictures of docs/evidence.md.

    evidence.py FIT_PROGRAM EVIDENCE_PROGRAM OUT [--write PAGE]     --write: put the tables into the page, between its marks
"""
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "common"))
import files  # noqa: E402
import pictures as draw  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
PUBLISHED = HERE / "published"
MUSCLE = PUBLISHED / "muscle"
SHAPE = PUBLISHED / "shape"
DOSES = [MUSCLE / "williams_1988.csv", PUBLISHED / "tabary_1972_shortened.csv", PUBLISHED / "tabary_1972_lengthened.csv",
         MUSCLE / "burkholder_1998.csv", MUSCLE / "panidi_2023.csv", PUBLISHED / "zollner_2012.csv", PUBLISHED / "csapo_2010.csv",
         PUBLISHED / "boakes_2007.csv"]


class Runs:
    def __init__(self, fit, evidence, out):
        self.programs, self.out = {"fit": fit, "evidence": evidence}, out

    def run(self, program, folder, *arguments):
        folder = self.out / folder
        done = subprocess.run([self.programs[program], *map(str, arguments), "--out", folder], capture_output=True, text=True)
        if done.returncode:
            raise files.FileError(f"{self.programs[program]} {' '.join(map(str, arguments))}: {done.stderr.strip()}")
        return files.read_json(folder / "report.json")

    def study(self, name, *rows):
        """A study file of the run: rows on top of another file."""
        path = self.out / f"{name}.csv"
        files.write_text(path, "\n".join(rows) + "\n")
        return path


def verdict(value, sd, computed, fitted):
    off = abs(computed - value) / sd
    if fitted and off <= 2:
        return "fitted, no test"
    return "consistent" if off <= 2 else "contradicted" if off > 3 else "undecided"


def row(title, m, fitted):
    off = 100 * (m["computed"] / m["value"] - 1)
    return (f"| {title} | {m['day']:g} | {m['quantity']} | {m['value']:.3f} ± {m['sd']:.3f} | {m['computed']:.3f} | {off:+.1f} % | "
            f"{(m['computed'] - m['value']) / m['sd']:+.1f} | {verdict(m['value'], m['sd'], m['computed'], fitted)} |")


def interval(p):
    ends = [f"{p[e]:.3g}" if p[e] is not None else "open" for e in ("lower", "upper")]
    return f"{p['estimate']:.3g} ({ends[0]} to {ends[1]})"


def comparisons(runs):
    rows = ["| study | day | quantity | published | law | off by | in sd | verdict |", "|---|---|---|---|---|---|---|---|"]
    reports = {}
    for path in sorted([*PUBLISHED.glob("*.csv"), *MUSCLE.glob("*.csv")], key=lambda p: p.stem):
        r = reports[path.stem] = runs.run("fit", path.stem, path, "--starts", 2)
        for m in r["measurements"]:
            rows.append(row(r["title"], m, len(r["parameters"]) >= len(r["measurements"])))
    return rows, reports


def time_constants(runs, reports):
    """What tau has to be, by each source and together."""
    rows = ["| source | assumption on the stretch | τ [d], 95 % by profile | χ² / measurements |", "|---|---|---|---|"]

    def add(name, assumption, r):
        tau = next(p for p in r["parameters"] if p["name"] == "tau")
        rows.append(f"| {name} | {assumption} | {interval(tau)} | {r['chi2']:.2f} / {len(r['measurements'])} |")
        return r

    equal = "stretch = fascicle length"
    for stem, name in (("pincheira_2022_distal", "Pincheira, distal, 3 weeks"), ("andrews_2025_distal", "Andrews, distal, 9 weeks"),
                       ("andrews_2025_central", "Andrews, central, 9 weeks")):
        add(name, equal, reports[stem])
    files_of_muscle = [MUSCLE / f"{s}.csv" for s in ("pincheira_2022_distal", "andrews_2025_distal", "andrews_2025_central")]
    add("all three together", equal, runs.run("fit", "joint", *files_of_muscle, "--starts", 2))
    free = runs.study("joint_crit", f"include, {files_of_muscle[0]}", "fit, lambda_crit, 0.8, 1.1")
    r = add("all three, λ_crit free", equal, runs.run("fit", "joint_crit", free, *files_of_muscle[1:], "--starts", 2))
    rows[-1] = rows[-1].replace("λ_crit free", "λ_crit = " + interval(r["parameters"][1]))
    for stem, name in (("biceps_femoris_distal", "both, distal, numbers only"), ("biceps_femoris_central", "both, central, numbers only")):
        add(name, "none: height fitted", reports[stem])
    numbers = [MUSCLE / f"biceps_femoris_{s}.csv" for s in ("distal", "central")]
    add("both regions, one height", "none: height fitted", runs.run("fit", "joint_numbers", *numbers, "--starts", 2))
    shape = [SHAPE / f"biceps_femoris_{s}.csv" for s in ("distal", "central")]
    add("both regions, heights by the muscle's shape", "from a real muscle", runs.run("fit", "shape", *shape, "--starts", 4))
    add("Takahashi, rabbit, week 1", "1.35 at the transfer", reports["takahashi_2010_week1"])
    add("Zöllner, week 2", "published", reports["zollner_2012"])
    return rows


def values_of(law):
    """The parameters of a law that were fitted, as text."""
    symbols = {"tau": "τ", "tau_rev": "τ_rev", "lambda_crit_rev": "λ_crit_rev", "tau_fall": "τ_fall", "tau_rise": "τ_rise",
               "x_half": "x_half"}
    days = {"tau", "tau_rev", "tau_fall", "tau_rise"}
    return ", ".join(f"{symbols[n]} = {v:.3g}{' d' if n in days else ''}" for n, v in zip(law["parameters"], law["values"]))


def law_name(law, tau):
    name = law["name"].replace("tau as set", f"τ = {tau:g} d held").replace("lambda_crit_rev", "λ_crit_rev")
    return name.replace("growth only", "growth only (eq. 4 as printed)")


def doses(runs):
    """The extensions of the law, each fitted to the same 12 figures of dose, and to 16 with those of other kinds."""
    base = ["--extensions", HERE / "dose.csv", "--set", "tau=0.5", MUSCLE / "williams_1990.csv", *DOSES]
    dose = runs.run("evidence", "extensions", *base)
    others = [MUSCLE / f"{s}.csv" for s in ("takahashi_2010_week1", "pincheira_2022_distal", "andrews_2025_distal",
                                             "andrews_2025_central")]
    every = runs.run("evidence", "extensions_all", *base, *others)
    n, m = len(dose["figures"]), len(every["figures"])
    rows = [f"| law | fitted | χ² of {n} | AIC = χ² + 2k | Δ AIC | worst, in sd | χ² of {m} |", "|---|---|---|---|---|---|---|"]

    def aic(law):
        return law["chi2"] + 2 * len(law["values"])

    least = min(map(aic, dose["laws"]))
    for law, more in zip(dose["laws"], every["laws"], strict=True):
        worst = max(abs(y - f["value"]) / f["sd"] for y, f in zip(law["computed"], dose["figures"], strict=True))
        rows.append(f"| {law_name(law, dose['tau'])} | {values_of(law)} | {law['chi2']:.1f} | {aic(law):.1f} | {aic(law) - least:.1f} | "
                    f"{worst:.1f} | {more['chi2']:.1f} |")
    shown = {"growth only": "growth only", "growth and removal, one rate": "one rate", "two rates": "two rates",
             "tau as set, two rates": "two rates, τ held", "one rate, sensed stretch that rises at once": "sensed, at once",
             "tau as set, one rate, sensed stretch with two time constants": "sensed, two times, τ held"}
    laws = [next(law for law in dose["laws"] if law["name"] == name) for name in shown]
    rows += ["", "| figure | published | " + " | ".join(shown.values()) + " |", "|---|---" + "|---" * len(shown) + "|"]
    for i, f in enumerate(dose["figures"]):
        values = " | ".join(f"{law['computed'][i]:.3f}" for law in laws)
        rows.append(f"| {f['title']}, day {f['day']:g}, {f['quantity']} | {f['value']:.3f} ± {f['sd']:.3f} | {values} |")
    two = runs.run("fit", "two_rates", HERE / "dose.csv", *DOSES, "--starts", 1)
    words = ", ".join(f"{n} = {interval(p)} d" for n, p in zip(("τ", "τ_rev"), two["parameters"]))
    return [*rows, "", f"Two rates, 95 % by profile (`./run fit`): {words}."]


def left_open(runs):
    """Which parameters the numbers of both regions leave open: all of them fitted together."""
    names = ("distal", "central")
    rows = ["| fitted to | τ [d] | γ | G_max | λ_crit | τ_rev [d] | height | χ² / measurements |", "|---" * 8 + "|"]
    for title, regions in (("distal", names[:1]), ("central", names[1:]), ("both, heights by shape", names)):
        path = runs.study("open_" + title.split(",")[0], f"include, {SHAPE / f'biceps_femoris_{regions[0]}.csv'}", "fit, gamma, 0, 8",
                          "fit, G_max, 1.5, 6", "fit, lambda_crit, 1, 1.06")
        r = runs.run("fit", path.stem, path, *[SHAPE / f"biceps_femoris_{name}.csv" for name in regions[1:]], "--starts", 2)
        by_name = {p["name"]: p for p in r["parameters"]}
        cells = [interval(by_name[n]) for n in ("tau", "gamma", "G_max", "lambda_crit", "tau_rev", "amplitude")]
        rows.append(f"| {title} | {' | '.join(cells)} | {r['chi2']:.2f} / {len(r['measurements'])} |")
    return rows


def tendon(runs):
    """The table of the tendon, and what is predicted as rows of the table of all comparisons."""
    r = runs.run("evidence", "tendon", PUBLISHED / "tendon" / "takahashi_2010.csv")
    heads = [f"{q}, day {d:g}: {v:.3f} ± {s:.3f}" for q, d, v, s in zip(r["quantity"], r["day"], r["value"], r["sd"])]
    rows = ["| fitted to | τ [d] | viscosity [kPa d] | " + " | ".join(heads) + " | χ² |", "|---" * (4 + len(heads)) + "|"]
    predicted = []
    for c in r["cases"]:
        for i, fitted in enumerate(c["fitted"]):
            if not fitted:
                m = {name: r[name][i] for name in ("day", "quantity", "value", "sd")}
                predicted.append(row(f"Takahashi 2010: with a tendon, {c['name']}", {**m, "computed": c["computed"][i]}, False))
        cells = [f"{y:.3f}" + ("" if fitted else f" predicted, {100 * (y / v - 1):+.1f} %")
                 for y, v, fitted in zip(c["computed"], r["value"], c["fitted"])]
        viscosity = "rigid" if c["viscosity"] is None else f"{c['viscosity']:.3g}"
        rows.append(f"| {c['name'][len('fitted to '):]} | {c['tau']:.2g} | {viscosity} | {' | '.join(cells)} | {c['chi2']:.1f} |")
    return rows, predicted


def areas(runs):
    """The same for growth across the fibre, and the report."""
    folder = PUBLISHED / "cross_section"
    r = runs.run("evidence", "areas", "--area", folder / "defreitas_2011.csv", "--predict", folder / "seynnes_2007.csv",
                 "--predict", folder / "damas_2016.csv")
    rows = [f"τ = {r['tau']:.3g} d, overload {r['overload']:.3f}; χ² = {r['chi2']:.2f} for 8 areas.", "",
            "| study | day | published | law | off by | verdict |", "|---|---|---|---|---|---|"]
    predicted = []
    for i, s in enumerate(r["studies"]):
        for day, value, sd, y in list(zip(s["day"], s["value"], s["sd"], s["computed"]))[1:]:
            m = {"day": day, "quantity": "area", "value": value, "sd": sd, "computed": y}
            if i > 0:
                predicted.append(row(f"{s['name'].replace('_', ' ').capitalize()}: cross-section", m, False))
            words = "fitted" if i == 0 else verdict(value, sd, y, False)
            rows.append(f"| {s['name']} | {day:g} | {value:.3f} ± {sd:.3f} | {y:.3f} | {100 * (y / value - 1):+.1f} % | {words} |")
    return rows, predicted, r


def cycles(dose):
    rows = ["| 3000 days of half an hour at 1.1 | tolerance | cycles computed | G | error |", "|---|---|---|---|---|"]
    return rows + [f"| {c['name']} | {c['tolerance']:g} | {c['evaluated']} | {c['G']:.4f} | {c['error']:.1e} |" for c in dose["control"]]


def pictures(out, reports, dose, area):
    plt = draw.plt
    with plt.rc_context(draw.GRID):
        fig, axes = plt.subplots(1, 2, figsize=(10.4, 3.6))
        for (stem, name), colour in zip((("pincheira_2022_distal", "Pincheira, distal, 3 weeks"),
                                         ("andrews_2025_distal", "Andrews, distal, 9 weeks"),
                                         ("andrews_2025_central", "Andrews, central, 9 weeks"),
                                         ("takahashi_2010_week1", "Takahashi, rabbit, week 1"),
                                         ("zollner_2012", "Zöllner, week 2")), draw.CYCLE):
            p = reports[stem]["parameters"][0]
            axes[0].plot(p["profile_x"], p["profile"], "-", color=colour, lw=1.3, label=name)
        axes[0].axhline(draw.CHI2_95, color="0.4", lw=0.9, ls=":")
        axes[0].axvline(0.5, color="0.4", lw=0.9, ls="--")
        axes[0].set(xscale="log", ylim=(-0.2, 10), xlabel=draw.SYMBOLS["tau"], ylabel=r"$\chi^2$ above its minimum")
        axes[0].xaxis.set_major_formatter("{x:g}")
        axes[0].set_title("what τ has to be (dashed: 0.5 d; dotted: 95 %)", loc="left")
        axes[0].legend()
        for s, colour in zip(area["studies"], draw.CYCLE):
            axes[1].errorbar(s["day"], s["value"], yerr=s["sd"], fmt="o", ms=4, capsize=2, lw=1, color=colour,
                             label=draw.literal(s["name"]))
        curve = sorted({(d, y) for s in area["studies"] for d, y in zip(s["day"], s["computed"])})
        axes[1].plot(*zip(*curve), color="0.3", lw=1.2, label="the law, fitted to DeFreitas")
        axes[1].set(xlabel="days of training", ylabel="relative cross-section [-]")
        axes[1].legend()
        fig.tight_layout()
        draw.save(fig, out / "evidence.png")
        fig, axes = plt.subplots(2, 4, figsize=(14.4, 6.4), sharex=True, sharey=True, layout="constrained")
        levels = [0.8, 0.85, 0.9, 0.95, 0.99, 1.01, 1.05, 1.1, 1.15, 1.2, 1.25, 1.3]
        for ax, m in zip(axes.flat, dose["maps"]):
            drawn = ax.contourf(dose["hours"], dose["stretch"], list(zip(*m["G"])), levels=levels, cmap="RdBu", extend="both",
                                norm=draw.matplotlib.colors.TwoSlopeNorm(1, 0.8, 1.3))
            if min(map(min, m["G"])) < 1:
                ax.contour(dose["hours"], dose["stretch"], list(zip(*m["G"])), levels=[1.0], colors="k", linewidths=0.8)
            ax.axvline(0.5, color="0.3", lw=0.9, ls="--")
            ax.set(xscale="log")
            ax.set_title(m["name"], loc="left")
            ax.xaxis.set_major_formatter("{x:g}")
        for ax in axes[1]:
            ax.set_xlabel("hours a day")
        for ax in axes[:, 0]:
            ax.set_ylabel("stretch [-]")
        fig.colorbar(drawn, ax=axes, ticks=levels, label=f"G after {dose['days']} days", fraction=0.025)
        draw.save(fig, out / "dose.png")


def write(page, parts):
    text = page.read_text(encoding="utf-8")
    for name, rows in parts.items():
        begin, end = f"<!-- {name}: written by ./run evidence --write -->\n", f"<!-- end of {name} -->"
        if text.count(begin) != 1 or text.count(end) != 1:
            raise files.FileError(f"{page}: expected one pair of the marks of '{name}'")
        head, rest = text.split(begin)
        text = head + begin + "\n" + "\n".join(rows) + "\n\n" + end + rest.split(end)[1]
    files.write_text(page, text)


def main(arguments):
    if len(arguments) not in (3, 5) or (len(arguments) == 5 and arguments[3] != "--write"):
        raise files.FileError(f"expected these arguments:\n{__doc__}")
    out = pathlib.Path(arguments[2]).resolve()
    files.make_folder(out)
    runs = Runs(*arguments[:2], out)
    table, reports = comparisons(runs)
    constants = time_constants(runs, reports)
    area_rows, predicted_areas, area = areas(runs)
    tendon_rows, predicted = tendon(runs)
    parts = {"comparisons": table + predicted + predicted_areas, "time constants": constants, "left open": left_open(runs),
             "tendon": tendon_rows, "dose": doses(runs), "areas": area_rows}
    dose = runs.run("evidence", "dose", "--dose", 42)
    parts["cycles"] = cycles(dose)
    pictures(out, reports, dose, area)
    files.write_text(out / "report.md", "\n\n".join(f"## {name}\n\n" + "\n".join(rows) for name, rows in parts.items()) + "\n")
    if len(arguments) == 5:
        write(pathlib.Path(arguments[4]), parts)
    print((out / "report.md").read_text(encoding="utf-8"))
    print(f"\nresults in {out}")


if __name__ == "__main__":
    with files.faults_in_one_line("evidence.py"):
        main(sys.argv[1:])
