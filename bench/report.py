"""Reads what `bench` has written (Google Benchmark's JSON), prints tables, and writes results.json, results.csv and
chart.png beside it.

The time of a point is the thread's CPU time over the number of threads: what a pass over the points would take with
the cores to itself. Medians over the repetitions.
"""
import argparse
import collections
import json
import math
import pathlib
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "examples/common"))
import files  # noqa: E402  shared by all Python programs

REFERENCE = "umat_"
BATCH = "batch AVX-512, "
# (what, in which case, slower variant, faster variant, the least ratio of their times), a growing point in cache.
GOALS = (
    ("Fortran -O2 over umat_, gamma 2.5", 2.5, "Fortran UMAT, -O2", REFERENCE, 1.7),
    ("Fortran -O2 over umat_, gamma 2", 2.0, "Fortran UMAT, -O2", REFERENCE, 2.8),
    ("numerical tangent over umat_", 2.0, "numerical tangent", REFERENCE, 15),
    ("kernel over batch AVX-512, full tangent", 2.0, "kernel", BATCH + "full", 9),
    ("Fortran -O2 over batch AVX-512, full tangent", 2.0, "Fortran UMAT, -O2", BATCH + "full", 30),
    ("kernel over batch AVX-512, compact tangent", 2.0, "kernel", BATCH + "compact", 11),
    ("umat_ over myogrowth_update_n", 2.0, REFERENCE, "myogrowth_update_n", 1 / 0.18),
    ("umat_, first over second order", 2.0, REFERENCE, "umat_, second order", 1 / 2.0),
    ("umat_ over second order, batch AVX-512, full", 2.0, REFERENCE, BATCH + "full, second order", 1 / 0.35),
    ("neo-Hookean over law 1, full tangent", 2.0, BATCH + "full", BATCH + "law 1, full", 0.4),
    ("neo-Hookean over law 1, compact tangent", 2.0, BATCH + "compact", BATCH + "law 1, compact", 0.4),
)
MOST_OF_BOUND = 1.5  # streamed: times the longer of what the copy takes for as many bytes, and the arithmetic in cache
Case = collections.namedtuple("Case", "place threads growth gamma")
Timing = collections.namedtuple("Timing", "ns quartiles read written difference")


def read(path):
    """{variant: {case: Timing}}, the copy's ns per element for each number of threads, and the run's context."""
    data = files.read_json(path)
    try:
        return figures_of(path, data)
    except (KeyError, TypeError, AttributeError, ValueError, IndexError) as e:
        if isinstance(e, files.FileError):
            raise
        raise files.FileError(f"{path}: is not what `bench` writes: {type(e).__name__} {e}") from None


def figures_of(path, data):
    repetitions = collections.defaultdict(list)
    for b in data["benchmarks"]:
        if b.get("error_occurred"):
            raise files.FileError(f"{path}: {b['name']}: {b['error_message']}")
        for name in ("cpu_time", "points", "threads") if b["run_type"] == "iteration" else ():
            if not 0 < b[name] < math.inf:
                raise files.FileError(f"{path}: {b['name']}: {name} = {b[name]}: expected a finite number > 0")
        if b["run_type"] == "iteration":
            repetitions[b["run_name"]].append(b)
    variants, copy = collections.defaultdict(dict), {}
    for name, runs in sorted(repetitions.items(), key=lambda item: item[1][0]["family_index"]):
        threads = runs[0]["threads"]
        ns = sorted(b["cpu_time"] / b["points"] / threads for b in runs)
        median = statistics.median(ns)
        if name.startswith("copy/"):
            copy[threads] = median
            continue
        variant, place, growth, gamma, _ = name.split("/")
        quartiles = (ns[len(ns) // 4], ns[-1 - len(ns) // 4])
        variants[variant][Case(place, threads, growth, float(gamma))] = Timing(
            median, quartiles, runs[0]["bytes_read"], runs[0]["bytes_written"], max(b["difference"] for b in runs))
    if not variants:
        raise files.FileError(f"{path}: has no timings: was the benchmark's filter too narrow?")
    return variants, copy, data["context"]


def cases_of(variants):
    return sorted({case for times in variants.values() for case in times},
                  key=lambda c: (c.place, c.threads, ("active", "half", "inactive").index(c.growth), c.gamma))


def ratio(variants, variant, case):
    reference = variants[REFERENCE].get(case)
    return variants[variant][case].ns / reference.ns if reference else None


def print_times(variants):
    """A table for each place and number of threads: a row per variant, a column per case, with the ratio to umat_."""
    cases = cases_of(variants)
    for place, threads in sorted({(c.place, c.threads) for c in cases}):
        columns = [c for c in cases if (c.place, c.threads) == (place, threads)]
        where = "in cache" if place == "cache" else "streamed through memory"
        print(f"\nns per point, {where}, {threads} thread{'s' * (threads > 1)} (in brackets: over {REFERENCE})")
        print(f"{'':32}" + "".join(f"{f'{c.growth}, {c.gamma:g}':>17}" for c in columns))
        for variant, times in variants.items():
            if not any(c in times for c in columns):
                continue
            row = ""
            for c in columns:
                r = ratio(variants, variant, c) if c in times else None
                row += f"{times[c].ns:9.1f} " + (f"({r:5.2f})" if r else "       ") if c in times else f"{'':17}"
            print(f"{variant:32}{row}")
    spread = [(t.quartiles[1] - t.quartiles[0]) / t.ns for times in variants.values() for t in times.values()]
    print(f"\nspread of the repetitions, quartile to quartile: {100 * statistics.median(spread):.0f} % of the median")
    print("largest difference from the kernel: " + "; ".join(
        f"{variant} {max(t.difference for t in times.values()):.1e}" for variant, times in variants.items()))


def bound_of(variant, timing, copy_ns):
    """Bytes that a point moves, and the ns that the copy takes for as many. The batch writes past the caches; elsewhere, and
    in the copy, memory that is written is read first (write-allocate)."""
    moved = timing.read + (1 if variant.startswith("batch") else 2) * timing.written
    return moved, moved * copy_ns / 24


def print_goals(variants, copy):
    def row(what, figure, wanted, met):
        print(f"{what:60}{figure:8.2f}  {wanted:12} {'met' if met else 'NOT MET'}")

    print("\ngoals")
    for what, gamma, slow, fast, least in GOALS:
        case = Case("cache", 1, "active", gamma)
        if case in variants.get(slow, {}) and case in variants.get(fast, {}):
            x = variants[slow][case].ns / variants[fast][case].ns
            row(what, x, f">= {least:.3g}", x >= least)
    for threads, copy_ns in sorted(copy.items()):
        for variant in (BATCH + "stress", BATCH + "compact", BATCH + "full"):
            times = variants.get(variant, {})
            streamed, in_cache = (times.get(Case(place, threads, "active", 2.0)) for place in ("streamed", "cache"))
            if streamed and in_cache:
                x = streamed.ns / max(bound_of(variant, streamed, copy_ns)[1], in_cache.ns)
                row(f"{variant}, streamed, {threads} thread{'s' * (threads > 1)}, over its bound", x,
                    f"<= {MOST_OF_BOUND:g}", x <= MOST_OF_BOUND)


def print_roofline(variants, copy, context):
    for gamma in ("2", "2.5"):
        flops, functions = float(context[f"flops, gamma {gamma}"]), float(context[f"functions, gamma {gamma}"])
        print(f"a growing point at gamma = {gamma}: {flops:.0f} flops and {functions:.1f} logarithms or powers in the kernel")
    for threads, ns in sorted(copy.items()):
        bandwidth = 24 / ns  # read, written, and read because written
        print(f"\ncopy, {threads} thread{'s' * (threads > 1)}: {16 / ns:.1f} GB/s of read and written, {bandwidth:.1f} GB/s with "
              "write-allocate; streamed, growing, gamma = 2:")
        print(f"{'':32}{'bytes':>8}{'moved':>12}{'bound, ns':>12}{'measured':>10}{'share':>8}{'flops/byte':>12}")
        for variant, times in variants.items():
            t = times.get(Case("streamed", threads, "active", 2.0))
            if not t:
                continue
            moved, bound = bound_of(variant, t, ns)
            print(f"{variant:32}{t.read + t.written:8.0f}{moved:12.0f}{bound:12.1f}{t.ns:10.1f}{100 * bound / t.ns:7.0f} %"
                  f"{float(context['flops, gamma 2']) / moved:12.2f}")


def write_results(variants, folder):
    rows = []
    for variant, times in variants.items():
        for case in sorted(times):
            name = variant + (", streamed" if case.place == "streamed" else "")
            rows.append({"name": name, "gamma": case.gamma, "growth": case.growth, "threads": case.threads,
                         "ns_per_point_median": round(times[case].ns, 2),
                         "ratio_to_umat": round(ratio(variants, variant, case) or 0, 4) or None})
    files.write_json(folder / "results.json", rows)
    files.write_csv(folder / "results.csv", rows[0], [row.values() for row in rows])


def draw(variants, path):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    shown = {2.0: "#0072b2", 2.5: "#e69f00"}  # Okabe and Ito's
    case = {gamma: Case("cache", 1, "active", gamma) for gamma in shown}
    names = [v for v, times in variants.items() if "second order" not in v and all(c in times for c in case.values())]
    if not names:
        return
    names.sort(key=lambda v: -variants[v][case[2.0]].ns)
    fig, ax = plt.subplots(figsize=(7.6, 0.8 + 0.4 * len(names)), dpi=120)
    height = 0.38
    for k, (gamma, colour) in enumerate(shown.items()):
        ns = [variants[v][case[gamma]].ns for v in names]
        at = [i + (0.5 - k) * height for i in range(len(names))]
        ax.barh(at, ns, height, color=colour, label=rf"$\gamma$ = {gamma:g}")
        for y, x, v in zip(at, ns, names):
            ax.text(x * 1.03, y, f"{x:.0f} ns   {ratio(variants, v, case[gamma]):.2g}×", va="center", fontsize=7.5)
    ax.set_xscale("log")
    every = [variants[v][c].ns for v in names for c in case.values()]
    ax.set_xlim(10 ** math.floor(math.log10(min(every) / 2)), 4 * max(every))
    ax.set_yticks(range(len(names)), names, fontsize=8.5)
    ax.set_xlabel("ns a growing point, one core, in cache: stress, G, and tangent but for \"stress\"\n"
                  f"(×: over {REFERENCE})", fontsize=8.5)
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(fontsize=8.5, frameon=False, loc="upper right")
    fig.tight_layout()
    with files.writing(path) as part:
        fig.savefig(part)


def main():
    p = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    p.add_argument("timings", type=pathlib.Path, help="what `bench --benchmark_out=FILE` has written")
    path = p.parse_args().timings
    files.remove(path.parent / name for name in ("results.json", "results.csv", "chart.png"))
    variants, copy, context = read(path)
    print_times(variants)
    print_roofline(variants, copy, context)
    print_goals(variants, copy)
    write_results(variants, path.parent)
    draw(variants, path.parent / "chart.png")
    print(f"\n{path.parent}/: {path.name}, results.json, results.csv, chart.png")


if __name__ == "__main__":
    with files.faults_in_one_line("report.py"):
        main()
