// Least squares for tau and lambda_crit by the residuals of ./run fit: (computed - measured)/sd, G by backward Euler in
// whole and half steps, extrapolated. Levenberg and Marquardt's method within bounds; profiles on ./run fit's points.
import {cut} from "./history.js";
import {InputError} from "./rows.js";
import {S} from "./strings.js";

export const PARAMETERS_OF_FIT = ["tau", "lambda_crit"];
const CHI2_95 = 3.841458820694124, Z_95 = 1.959963984540054;

/** The data of a fit. measurements: {time, quantity, value, sd}; bounds: {tau: [low, high], ...}. */
export class Fit {
  constructor(law, muscle, knots, measurements, bounds) {
    Object.assign(this, {law, muscle, measurements, bounds: PARAMETERS_OF_FIT.map((name) => bounds[name])});
    this.points = cut(knots, measurements.map((m) => m.time), 0.002, 0.06);
    this.at = measurements.map((m) => {
      let i = this.points.time.length;
      while (this.points.time[i - 1] > m.time + 1e-9) --i;
      return i - 1;
    });
  }

  muscleAt(x) {
    const muscle = Object.assign({}, this.muscle);
    PARAMETERS_OF_FIT.forEach((name, k) => { muscle[name] = x[k]; });
    return muscle;
  }

  residuals(x) {
    const G = this.law.grow(this.muscleAt(x), this.points);
    return this.measurements.map((m, i) => {
      const g = G[this.at[i]];
      return ((m.quantity === "G" ? g : this.points.stretch[this.at[i]] / g) - m.value) / m.sd;
    });
  }

  chi2(x) {
    return this.residuals(x).reduce((sum, r) => sum + r * r, 0);
  }

  /** Columns of derivatives of the residuals, by central differences. */
  jacobian(x, free) {
    return free.map((k) => {
      const h = 1e-5 * (k === 0 ? x[k] : 0.1), at = (n) => this.residuals(x.map((v, j) => v + (j === k ? n * h : 0)));
      const low = at(-1);
      return at(1).map((r, i) => (r - low[i]) / (2 * h));
    });
  }

  /** The minimum from a start over the parameters `free`: {x, chi2}. */
  minimise(start, free, tolerance = 1e-11) {
    const clip = (x) => x.map((v, k) => Math.min(Math.max(v, this.bounds[k][0]), this.bounds[k][1]));
    let x = clip(start), chi2 = this.chi2(x), damping = 1e-3;
    for (let iteration = 0; iteration < 200 && free.length > 0; ++iteration) {
      const r = this.residuals(x), J = this.jacobian(x, free);
      const gradient = J.map((column) => dot(column, r));
      // A parameter at its bound that wants to leave is held.
      const active = free.map((k, i) => i).filter((i) => {
        const [low, high] = this.bounds[free[i]], v = x[free[i]];
        return !((v <= low && gradient[i] > 0) || (v >= high && gradient[i] < 0));
      });
      if (active.length === 0) break;
      let moved = 0;
      for (let tries = 0; tries < 30; ++tries) {
        const A = active.map((i) => active.map((j) => dot(J[i], J[j]) * (i === j ? 1 + damping : 1)));
        const step = solve(A, active.map((i) => -gradient[i])), next = x.slice();
        active.forEach((i, n) => { next[free[i]] += step[n]; });
        const inside = clip(next), value = this.chi2(inside);
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

  wide(k) {
    const [low, high] = this.bounds[k];
    return low > 0 && high > 10 * low;
  }

  /** From 0 at the lower bound to 1 at the upper one. */
  valueAt(k, part) {
    const [low, high] = this.bounds[k];
    return this.wide(k) ? low * Math.pow(high / low, part) : low + (high - low) * part;
  }

  /** Best fit from several starts, with the intervals of curvature and profile: {x, chi2, parameters, agreeing, starts}. */
  best(start, starts = 8) {
    const fits = [this.minimise(start, [0, 1])];
    for (let s = 1; s < starts; ++s)
      fits.push(this.minimise([this.valueAt(0, (s - 0.5) / (starts - 1)), this.valueAt(1, (s * 0.618034) % 1)], [0, 1]));
    fits.sort((a, b) => a.chi2 - b.chi2);
    const best = fits[0], agreeing = fits.filter((f) => f.chi2 <= best.chi2 + 1e-6 * (1 + best.chi2)).length;
    const J = this.jacobian(best.x, [0, 1]), A = J.map((a) => J.map((b) => dot(a, b)));
    const determinant = A[0][0] * A[1][1] - A[0][1] * A[1][0];
    const known = determinant > 1e-14 * A[0][0] * A[1][1];
    const sd = [0, 1].map((k) => known ? Math.sqrt(A[1 - k][1 - k] / determinant) : NaN);
    const parameters = PARAMETERS_OF_FIT.map((name, k) => {
      const [lower, upper] = this.profile(best, k, sd[k]);
      const x = best.x[k], [low, high] = this.bounds[k], edge = 1e-6 * (high - low);
      return {name, estimate: x, sd: sd[k], low: x - Z_95 * sd[k], high: x + Z_95 * sd[k], lower, upper,
        atBound: x - low < edge || high - x < edge};
    });
    return {x: best.x, chi2: best.chi2, parameters, agreeing, starts, n: this.measurements.length,
      correlation: known ? -A[0][1] / Math.sqrt(A[0][0] * A[1][1]) : NaN};
  }

  /** Where the least chi2 with parameter k held rises by CHI2_95 on either side; infinite: not within the bounds. */
  profile(best, k, sd) {
    return this.bounds[k].map((bound) => {
      const x0 = best.x[k], reach = 5 * sd, near = Math.abs(bound - x0) > reach;
      const end = this.endOfSide(best, k, near ? x0 + Math.sign(bound - x0) * reach : bound);
      return near && !isFinite(end) ? this.endOfSide(best, k, bound) : end;
    });
  }

  endOfSide(best, k, end) {
    const n = 20, x0 = best.x[k], others = [1 - k], side = [];
    const byFactors = end > 0 && (end > 4 * x0 || x0 > 4 * end);
    let last = best;
    const held = (x, value) => x.map((v, j) => j === k ? value : v);
    for (let i = 1; i <= n && last.chi2 - best.chi2 < 5 * CHI2_95; ++i) {
      const value = byFactors ? x0 * Math.pow(end / x0, i / n) : x0 + (end - x0) * (i / n);
      last = this.minimise(held(last.x, value), others, 1e-8); // chi2 is flat there
      side.push(last);
    }
    for (let i = side.length - 1; i > 0; --i) {
      const again = this.minimise(held(side[i].x, side[i - 1].x[k]), others, 1e-8);
      if (again.chi2 < side[i - 1].chi2) side[i - 1] = again;
    }
    const root = (f) => Math.sqrt(Math.max(f.chi2 - best.chi2, 0)), wanted = Math.sqrt(CHI2_95);
    if (side.length === 0 || root(side[side.length - 1]) < wanted) return Infinity;
    let i = side.length - 1;
    while (i > 0 && root(side[i - 1]) >= wanted) --i;
    const inner = i > 0 ? side[i - 1] : best, outer = side[i];
    return inner.x[k] + (outer.x[k] - inner.x[k]) * (wanted - root(inner)) / (root(outer) - root(inner));
  }
}

const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);

function solve(A, b) {
  if (b.length === 1) return [b[0] / A[0][0]];
  const determinant = A[0][0] * A[1][1] - A[0][1] * A[1][0];
  return [(b[0] * A[1][1] - A[0][1] * b[1]) / determinant, (A[0][0] * b[1] - A[1][0] * b[0]) / determinant];
}

/** Measurements of a study as the page can fit them; says what it cannot. */
export function checkFit(study) {
  if (study.measurements.length === 0) throw new InputError(S.fit.noMeasurements(study.name));
  if (study.knots.length < 2) throw new InputError(S.fit.noHistory(study.name));
  for (const b of study.fitted)
    if (!PARAMETERS_OF_FIT.includes(b.name)) throw new InputError(`${b.place}: ${S.fit.onlyTwo(b.name)}`);
}
