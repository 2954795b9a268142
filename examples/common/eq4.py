"""Eq. 4 at a point whose fibre stretch is ramped and held: the solution to nine digits, without the library's code."""
import math

import numpy as np


def stretch(a, t):
    """The fibre stretch at a time: from 1 at 0 to a.stretch at a.ramp, then held."""
    return a.stretch if t >= a.ramp else 1 + (a.stretch - 1) * t / a.ramp


# The method Radau IIA with three stages: order 5, and stable in steps of any length.
MOST_STEPS = 1000  # twenty times what usual parameters take
ROOT = math.sqrt(6)
STAGES = np.array([(4 - ROOT) / 10, (4 + ROOT) / 10, 1])
WEIGHTS = np.array([[(88 - 7 * ROOT) / 360, (296 - 169 * ROOT) / 1800, (-2 + 3 * ROOT) / 225],
                    [(296 + 169 * ROOT) / 1800, (88 + 7 * ROOT) / 360, (-2 - 3 * ROOT) / 225],
                    [(16 - ROOT) / 36, (16 + ROOT) / 36, 1 / 9]])


def exact(a, times, tolerance=1e-11):
    """G at the increasing times >= 0, by steps whose error is below the tolerance each.

    a: stretch, ramp, tau, gamma, G_max, lambda_crit.
    The variable is z with dz = dG/((G_max - 1) y^gamma), y = (G_max - G)/(G_max - 1): eq. 4 is then
    dz/dt = <lambda/G - lambda_crit>/(tau (G_max - 1)), smooth up to G_max for every gamma, and G(z) <= G_max. The rate
    of eq. 4 falls as G grows, so errors of earlier steps only shrink: that of G is below the sum of the tolerances.
    """

    def log_y(z):
        z = np.maximum(z, 0)  # below are only iterates of Newton's method
        if a.gamma == 1:
            return -z
        with np.errstate(divide="ignore", over="ignore"):
            return np.log1p(np.maximum((a.gamma - 1) * z, -1)) / (1 - a.gamma)

    def G_of(z):
        return 1 - (a.G_max - 1) * np.expm1(log_y(z))

    def rate(t, z):
        """dz/dt and its derivative by z."""
        G = G_of(z)
        lam = np.where(t >= a.ramp, a.stretch, 1 + (a.stretch - 1) * t / (a.ramp or 1))
        tension = lam / G - a.lambda_crit
        y = np.exp(log_y(z))
        slope = np.where(y > 0, -lam / G**2 * y**a.gamma / a.tau, 0)
        if a.stretch < 1:  # else what has begun to grow never stops
            slope = np.where(tension > 0, slope, 0)
            tension = np.maximum(tension, 0)
        return tension / (a.tau * (a.G_max - 1)), slope

    def advance(t, z, h):
        """z at t + h for an array h, and whether Newton's method has found it."""
        h = h[:, None]
        Z = rate(np.float64(t), np.float64(z))[0] * STAGES * h  # what z grows by at the stages
        for _ in range(30):
            value, slope = rate(t + STAGES * h, z + Z)
            matrix = np.eye(3) - h[:, :, None] * WEIGHTS * slope[:, None, :]
            change = np.linalg.solve(matrix, (h * (value @ WEIGHTS.T) - Z)[:, :, None])[:, :, 0]
            Z += change
            found = np.all(np.abs(change) <= 1e-14 * (1 + np.abs(z + Z)), axis=1)
            if found.all():
                break
        return z + Z[:, 2], found

    times = np.asarray(times, dtype=float)
    t, z, h, tried = 0.0, 0.0, 1e-3 * a.tau, 0
    if a.lambda_crit >= 1:  # nothing grows before the stretch is lambda_crit
        if a.stretch <= a.lambda_crit:
            return np.ones(len(times))
        t = a.ramp * (a.lambda_crit - 1) / (a.stretch - 1)
    result = np.ones(len(times))
    for end in (min(a.ramp, times[-1]), times[-1]):  # at the end of the ramp the rate has a kink
        while t < end:
            h = min(h, end - t)
            tried += 1
            if tried > MOST_STEPS:
                raise ValueError(f"eq. 4 takes more than {MOST_STEPS} steps by time {t:g} of {end:g}: tau = {a.tau:g}, "
                                 f"gamma = {a.gamma:g}, G_max = {a.G_max:g}, lambda_crit = {a.lambda_crit:g}")
            (whole, half), found = advance(t, z, np.array([h, h / 2]))
            (two,), found_two = advance(t + h / 2, half, np.array([h / 2]))
            error = abs(G_of(two) - G_of(whole)) if found.all() and found_two.all() else math.inf
            if error > tolerance:
                if t + h == t:
                    raise ValueError(f"eq. 4 beyond time {t:g}: no step is short enough for tau = {a.tau:g}")
                h *= max(0.1, 0.9 * (tolerance / error) ** (1 / 6))
                continue
            following = end if h == end - t else t + h
            inside = (times > t) & (times <= following)
            if inside.any():
                result[inside] = G_of(advance(t, z, times[inside] - t)[0])
            t, z = following, two
            h *= min(10, 0.9 * (tolerance / max(error, 1e-6 * tolerance)) ** (1 / 6))
    return result
