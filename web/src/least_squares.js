// Levenberg and Marquardt's method within bounds. A problem has residuals(x), and bounds, [low, high] of every parameter.

export function chi2Of(problem, x) {
  return problem.residuals(x).reduce((sum, r) => sum + r * r, 0);
}

/** Columns of derivatives of the residuals, by central differences. */
export function jacobian(problem, x, free) {
  return free.map((k) => {
    const h = 1e-5 * (k === 0 ? x[k] : 0.1), at = (n) => problem.residuals(x.map((v, j) => v + (j === k ? n * h : 0)));
    const low = at(-1);
    return at(1).map((r, i) => (r - low[i]) / (2 * h));
  });
}

/** The minimum from a start over the parameters `free`: {x, chi2}. */
export function minimise(problem, start, free, tolerance = 1e-11) {
  const clip = (x) => x.map((v, k) => Math.min(Math.max(v, problem.bounds[k][0]), problem.bounds[k][1]));
  let x = clip(start), chi2 = chi2Of(problem, x), damping = 1e-3;
  for (let iteration = 0; iteration < 200 && free.length > 0; ++iteration) {
    const r = problem.residuals(x), J = jacobian(problem, x, free);
    const gradient = J.map((column) => dot(column, r));
    // A parameter at its bound that wants to leave is held.
    const active = free.map((k, i) => i).filter((i) => {
      const [low, high] = problem.bounds[free[i]], v = x[free[i]];
      return !((v <= low && gradient[i] > 0) || (v >= high && gradient[i] < 0));
    });
    if (active.length === 0) break;
    let moved = 0;
    for (let tries = 0; tries < 30; ++tries) {
      const A = active.map((i) => active.map((j) => dot(J[i], J[j]) * (i === j ? 1 + damping : 1)));
      const step = solve(A, active.map((i) => -gradient[i])), next = x.slice();
      active.forEach((i, n) => { next[free[i]] += step[n]; });
      const inside = clip(next), value = chi2Of(problem, inside);
      if (value <= chi2) {
        moved = Math.max(...inside.map((v, k) => Math.abs(v - x[k]) / (Math.abs(x[k]) + 1e-12)));
        x = inside;
        chi2 = value;
        damping = Math.max(damping / 10, 1e-12);
        break;
      }
      damping = Math.max(damping * 8, 1e-9);
      if (damping > 1e12) break;
    }
    if (!(moved > tolerance)) break;
  }
  return {x, chi2};
}

export const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);

function solve(A, b) {
  if (b.length === 1) return [b[0] / A[0][0]];
  const determinant = A[0][0] * A[1][1] - A[0][1] * A[1][0];
  return [(b[0] * A[1][1] - A[0][1] * b[1]) / determinant, (A[0][0] * b[1] - A[1][0] * b[0]) / determinant];
}
