"""Eq. 4 at a point whose fibre stretch is ramped and held: the solution to eleven digits, apart from the library's code."""


def stretch(a, t):
    """The fibre stretch at a time: from 1 at 0 to a.stretch at a.ramp, then held."""
    return a.stretch if t >= a.ramp else 1 + (a.stretch - 1) * t / a.ramp


def exact(a, times):
    """G at the increasing times >= 0, by the classical Runge-Kutta method, its steps halved until that changes nothing.

    a: stretch, ramp, tau, gamma, G_max, lambda_crit.
    """

    def rate(t, G):
        capacity = max(a.G_max - G, 0.0) / (a.G_max - 1)
        if capacity == 0:
            return 0.0
        return capacity**a.gamma * max(stretch(a, t) / G - a.lambda_crit, 0.0) / a.tau

    def after(G, t, end, n):
        h = (end - t) / n
        for i in range(n):
            s = t + i * h
            k1 = rate(s, G)
            k2 = rate(s + h / 2, G + h / 2 * k1)
            k3 = rate(s + h / 2, G + h / 2 * k2)
            k4 = rate(s + h, G + h * k3)
            G += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return G

    # The rate has a kink where the ramp crosses the threshold and where it ends: steps end there.
    knots = {a.ramp}
    if a.stretch > a.lambda_crit:
        knots.add(a.ramp * max(a.lambda_crit - 1, 0.0) / (a.stretch - 1))
    largest = max(1.0, min(a.G_max, a.stretch / a.lambda_crit))  # an unstable step leaves G's bounds
    G, t, result = 1.0, 0.0, {}
    for end in sorted(knots | set(times)):
        before, n = None, 8
        while end > t:
            found = after(G, t, end, n)
            if before is not None and abs(found - before) <= 1e-12 and G <= found <= largest + 1e-12:
                G = found
                break
            before, n = found, 2 * n
            if n > 2**22:
                raise ValueError(f"eq. 4 from {t:g} to {end:g}: more than {n} steps are needed with tau = {a.tau:g}")
        t = max(t, end)
        result[end] = G
    return [result[t] for t in times]
