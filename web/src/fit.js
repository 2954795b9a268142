// Least squares for tau and lambda_crit by the residuals of ./run fit: (computed - measured)/sd, G by backward Euler in
// whole and half steps, extrapolated. Levenberg and Marquardt's method within bounds; profiles on ./run fit's points.
import {cut} from "./history.js";
import {dot, jacobian, minimise} from "./least_squares.js";
import {FITTED, rangeFault} from "./model.js";
import {S} from "./strings.js";
import {InputError, textOf} from "./text.js";

const MOST_MEASUREMENTS = 500, MOST_POINTS = 1500; // a fit computes the history some thousand times
const CHI2_95 = 3.841458820694124, Z_95 = 1.959963984540054;

/** The data of a fit. measurements: {time, quantity, value, sd}; bounds: {tau: [low, high], ...}. */
export class Fit {
  constructor(law, muscle, knots, measurements, bounds) {
    Object.assign(this, {law, muscle, measurements, bounds: FITTED.map((name) => bounds[name])});
    this.points = cut(knots, measurements.map((m) => m.time), 0.002, 0.06);
    if (this.points.time.length > MOST_POINTS) throw new InputError(S.fit.tooLong(this.points.time.length, MOST_POINTS));
    this.at = measurements.map((m) => {
      let i = this.points.time.length;
      while (this.points.time[i - 1] > m.time + 1e-9) --i;
      return i - 1;
    });
  }

  muscleAt(x) {
    const muscle = Object.assign({}, this.muscle);
    FITTED.forEach((name, k) => { muscle[name] = x[k]; });
    return muscle;
  }

  residuals(x) {
    const G = this.law.grow(this.muscleAt(x), this.points);
    return this.measurements.map((m, i) => {
      const g = G[this.at[i]];
      return ((m.quantity === "G" ? g : this.points.stretch[this.at[i]] / g) - m.value) / m.sd;
    });
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
    const fits = [minimise(this, start, [0, 1])];
    for (let s = 1; s < starts; ++s)
      fits.push(minimise(this, [this.valueAt(0, (s - 0.5) / (starts - 1)), this.valueAt(1, (s * 0.618034) % 1)], [0, 1]));
    fits.sort((a, b) => a.chi2 - b.chi2);
    const best = fits[0], agreeing = fits.filter((f) => f.chi2 <= best.chi2 + 1e-6 * (1 + best.chi2)).length;
    const J = jacobian(this, best.x, [0, 1]), A = J.map((a) => J.map((b) => dot(a, b)));
    const determinant = A[0][0] * A[1][1] - A[0][1] * A[1][0];
    const known = determinant > 1e-14 * A[0][0] * A[1][1];
    const sd = [0, 1].map((k) => known ? Math.sqrt(A[1 - k][1 - k] / determinant) : NaN);
    const parameters = FITTED.map((name, k) => {
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
      last = minimise(this, held(last.x, value), others, 1e-8); // chi2 is flat there
      side.push(last);
    }
    for (let i = side.length - 1; i > 0; --i) {
      const again = minimise(this, held(side[i].x, side[i - 1].x[k]), others, 1e-8);
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

/**
 * The bounds of a study's fit, {tau: [low, high], ...}: its own, or the page's `otherwise`. Says what this page cannot fit,
 * and which bounds are not allowed, as examples/common/study.hpp does.
 */
export function boundsOf(law, study, muscle, otherwise) {
  if (study.measurements.length === 0) throw new InputError(S.fit.noMeasurements(study.name));
  if (study.measurements.length > MOST_MEASUREMENTS)
    throw new InputError(S.fit.tooMany(study.measurements.length, MOST_MEASUREMENTS));
  if (study.knots.length < 2) throw new InputError(S.fit.noHistory(study.name));
  const bounds = {};
  for (const name of FITTED) bounds[name] = otherwise[name];
  for (const {name, lower, upper, place} of study.fitted) {
    if (!FITTED.includes(name)) throw new InputError(`${place}: ${S.fit.onlyTwo(name)}`);
    const start = study.set[name];
    if (start !== undefined && !(lower <= start && start <= upper)) {
      throw new InputError(`${study.places[name]}: ${name} = ${textOf(start)}: expected a start within the bounds of its ` +
        `fit, ${textOf(lower)} to ${textOf(upper)}`);
    }
    bounds[name] = [lower, upper];
    const wrong = rangeFault(law, muscle, {[name]: bounds[name]});
    if (wrong) throw new InputError(`${place}: ${wrong.text}`);
  }
  const wrong = rangeFault(law, muscle, bounds); // the page's bounds beside what the study sets
  if (wrong) throw new InputError(S.fit.bound(S.muscle.symbols[wrong.name], wrong.text));
  return bounds;
}
