"""Times myogrowth.update on a million points beside myogrowth_update_n, NumPy written out by hand and a Python loop.

All variants take turns in one run, and the table has medians of CPU time a point. ./run bench-python runs it.
"""
import argparse
import ctypes
import pathlib
import platform
import statistics
import sys
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "examples/common"))
import files  # noqa: E402  shared by all Python programs

DT, MEASURES = 0.1, ("cauchy", "first_piola", "second_piola")


def arguments():
    p = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    p.add_argument("library", type=pathlib.Path, help="libmyogrowth.so")
    p.add_argument("--points", type=int, default=1_000_000, help="(default %(default)s)")
    p.add_argument("--rounds", type=int, default=5, help="turns of every variant, at least 1 (default %(default)s)")
    a = p.parse_args()
    if a.points < 1000 or a.rounds < 1:
        p.error(f"--points {a.points} --rounds {a.rounds}: must be at least 1000 and 1")
    return a


def growing_points(n):
    random = np.random.default_rng(1)
    F = np.eye(3) + 0.02 * random.uniform(-1, 1, (n, 3, 3))
    F[:, 0, 0] += 0.07
    n0 = random.normal(size=(n, 3)) * (0.1, 0.1, 0.1) + (1, 0, 0)
    n0 /= np.linalg.norm(n0, axis=1)[:, None]
    return F, n0, random.uniform(1, 1.02, n)


def update_n(library):
    """myogrowth_update_n over arrays in C's order that are there already; a function for every measure and tangent."""
    call = ctypes.CDLL(str(library)).myogrowth_update_n
    call.restype = ctypes.c_int

    def prepare(muscle, F, n0, G, measure, tangent):
        n, size = len(F), 9 if measure == "first_piola" else 6
        columns = np.ascontiguousarray(F.swapaxes(1, 2))
        props, state = muscle._props(), np.zeros((n, 8))
        state[:, 0], state[:, 2], state[:, 5:] = G, 1, n0
        out = [np.zeros_like(state), np.zeros((n, size)), np.zeros((n, size * size)) if tangent else None]
        pointer = [None if x is None else x.ctypes.data_as(ctypes.c_void_p) for x in (props, columns, state, *out)]

        def run(new=False):
            if new:
                out[:] = [None if x is None else np.empty_like(x) for x in out]
                pointer[3:] = [None if x is None else x.ctypes.data_as(ctypes.c_void_p) for x in out]
            failed = call(n, pointer[0], len(props), pointer[1], pointer[2], pointer[3], 8, ctypes.c_double(DT),
                          MEASURES.index(measure), pointer[4], pointer[5], None, None, None, 0)
            assert failed == 0
            return out[0][:, 0]
        return run
    return prepare


def by_hand(m, F, n0, G_n, tangent):
    """Growth, Cauchy stress and tangent as a NumPy user writes them."""
    I = np.eye(3)
    f = np.einsum("nij,nj->ni", F, n0)
    stretch = np.sqrt(np.einsum("ni,ni->n", f, f))
    grows = (stretch > m.lambda_crit * G_n) & (G_n < m.G_max)
    G = G_n.copy()
    for _ in range(20):
        left = np.maximum(m.G_max - G, 0) / (m.G_max - 1)
        k, phi = left**m.gamma / m.tau, stretch / G - m.lambda_crit
        slope = 1 + DT * (m.gamma * left**(m.gamma - 1) / (m.G_max - 1) / m.tau * phi + k * stretch / G**2)
        step = np.where(grows, (G - G_n - DT * k * phi) / slope, 0)
        G = G - step
        if np.abs(step).max() < 1e-15:
            break
    J = np.linalg.det(F)
    ff = np.einsum("ni,nj->nij", f, f)
    be = np.einsum("nik,njk->nij", F, F) + (1 / G**2 - 1)[:, None, None] * ff
    stress = (m.c1 * np.log(J / G)[:, None, None] * I + m.c2 * (be - I)) / J[:, None, None]
    if not tangent:
        return G, stress, None
    left = (m.G_max - G) / (m.G_max - 1)
    k, phi = left**m.gamma / m.tau, stretch / G - m.lambda_crit
    slope = 1 + DT * (m.gamma * left**(m.gamma - 1) / (m.G_max - 1) / m.tau * phi + k * stretch / G**2)
    dG = np.where(grows, DT * k / G / slope, 0)
    dtau = -(m.c1 / G)[:, None, None] * I - (2 * m.c2 / G**3)[:, None, None] * ff
    b_I = np.einsum("nik,jl->nijkl", be, I)
    c = m.c1 * np.einsum("ij,kl->ijkl", I, I) + m.c2 / 2 * (
        b_I + np.einsum("nil,jk->nijkl", be, I) + np.einsum("ik,njl->nijkl", I, be) + np.einsum("il,njk->nijkl", I, be))
    c = c + np.einsum("n,nij,nkl->nijkl", dG / stretch, dtau, ff)
    return G, stress, c / J[:, None, None, None, None]


def processor():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def ns_a_point(function, n, clock=time.thread_time):
    start = clock()
    function()
    return (clock() - start) / n * 1e9


def main():
    a = arguments()
    import myogrowth
    muscle, c_api = myogrowth.Parameters(), update_n(a.library)
    F, n0, G = growing_points(a.points)
    state = myogrowth.State(G=G, n0=n0)
    few, one_by_one = min(a.points, 50_000), 500

    def python(measure, tangent, **options):
        return myogrowth.update(muscle, F, DT, state, measure=measure, tangent=tangent, **options)

    def loop(tangent):
        for i in range(one_by_one):
            by_hand(muscle, F[i:i + 1], n0[i:i + 1], G[i:i + 1], tangent)

    def loop_of_update(measure, tangent):
        for i in range(one_by_one):
            myogrowth.update(muscle, F[i], DT, myogrowth.State(G=G[i], n0=n0[i]), measure=measure, tangent=tangent)

    print(f"{processor()}, NumPy {np.__version__}, {a.points} points, {time.strftime('%Y-%m-%d')}; ns of CPU time a point,\n"
          "medians; in brackets: over myogrowth_update_n, with new arrays where it makes them\n\n"
          "| measure, tangent | `myogrowth_update_n` | `update(..., out=)` | `myogrowth_update_n`, new arrays | `update(...)` "
          "| 2 threads, `out=`, elapsed | NumPy by hand | loop over points: `update` / by hand |\n|---|---|---|---|---|---|---|---|", flush=True)
    for measure in MEASURES:
        for tangent in (False, True):
            in_c, out = c_api(muscle, F, n0, G, measure, tangent), python(measure, tangent)
            difference = np.abs(in_c() - out.state.G).max()
            if measure == "cauchy":
                for theirs, ours in zip(by_hand(muscle, F[:few], n0[:few], G[:few], tangent), (out.state.G, out.stress, out.tangent)):
                    if ours is not None:
                        difference = max(difference, np.abs(theirs - ours[:few]).max())
            if not difference < 1e-10:
                sys.exit(f"FAILED: {measure}: results differ by {difference:g}")
            times = {"C": [], "new C": [], "out": [], "new": [], "threads": [], "hand": [], "loop": [], "hand loop": []}
            for _ in range(a.rounds):
                times["C"].append(ns_a_point(in_c, a.points))
                times["out"].append(ns_a_point(lambda: python(measure, tangent, out=out), a.points))
                times["new C"].append(ns_a_point(lambda: in_c(new=True), a.points))
                times["new"].append(ns_a_point(lambda: python(measure, tangent), a.points))
                times["threads"].append(ns_a_point(lambda: python(measure, tangent, out=out, threads=2), a.points, time.perf_counter))
                times["loop"].append(ns_a_point(lambda: loop_of_update(measure, tangent), one_by_one))
                if measure == "cauchy":
                    times["hand"].append(ns_a_point(lambda: by_hand(muscle, F[:few], n0[:few], G[:few], tangent), few))
                    times["hand loop"].append(ns_a_point(lambda: loop(tangent), one_by_one))
            ns = {name: statistics.median(t) if t else None for name, t in times.items()}

            def cell(name, over="C"):
                return "" if ns[name] is None else f"{ns[name]:.0f} ({ns[name] / ns[over]:.2f})"
            by_hand_one = "" if ns["hand loop"] is None else f" / {ns['hand loop']:.0f}"
            print(f"| {measure}, {'full' if tangent else 'none'} | {ns['C']:.0f} | {cell('out')} | {ns['new C']:.0f} "
                  f"| {cell('new', 'new C')} | {cell('threads')} "
                  f"| {cell('hand')} | {ns['loop']:.0f}{by_hand_one} |", flush=True)


if __name__ == "__main__":
    with files.faults_in_one_line("python_update.py"):
        main()
