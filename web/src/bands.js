// Bands from the ranges of the parameters: many histories, each with its own parameters, and their percentiles.
import {cut} from "./history.js";

export const RANGED = ["tau", "gamma", "G_max", "lambda_crit", "c1", "c2"];
const BASES = [2, 3, 5, 7, 11, 13];

/** Entry i of the van der Corput sequence: evenly spread numbers in [0, 1), the same in every run (Halton's points). */
function spread(i, base) {
  let x = 0;
  for (let f = 1 / base; i > 0; f /= base, i = Math.floor(i / base)) x += f * (i % base);
  return x;
}

/** Time steps for many histories: fewer than for one. Errors of lambda_e are below 1e-4 (docs/web.md). */
export function coarse(knots) {
  return cut(knots, [], 0.02, 0.1, 0.01);
}

/** Histories that are added in pieces, so that the page stays alive. */
export class Bands {
  constructor(law, muscle, ranges, points) {
    Object.assign(this, {law, muscle, ranges, points, runs: []});
  }

  /** n more histories. */
  add(n) {
    for (let i = 0; i < n; ++i) {
      const at = this.runs.length + 1, muscle = Object.assign({}, this.muscle);
      RANGED.forEach((name, k) => {
        const [low, high] = this.ranges[name];
        muscle[name] = low + (high - low) * spread(at, BASES[k]);
      });
      this.runs.push(this.law.pull(muscle, this.points));
    }
  }

  /** Percentiles of a curve over time: an array for each of the fractions. */
  percentiles(name, fractions) {
    const n = this.points.time.length, found = fractions.map(() => new Float64Array(n));
    const column = new Float64Array(this.runs.length);
    for (let t = 0; t < n; ++t) {
      for (let i = 0; i < column.length; ++i) column[i] = this.runs[i][name][t];
      percentilesOf(column, fractions).forEach((x, k) => { found[k][t] = x; });
    }
    return found;
  }

  /** Percentiles of a number of every history. */
  ofEach(number, fractions) {
    return percentilesOf(Float64Array.from(this.runs, number), fractions);
  }
}

function percentilesOf(values, fractions) {
  values.sort();
  return fractions.map((f) => {
    const at = f * (values.length - 1), low = Math.floor(at), part = at - low;
    return part > 0 ? values[low] + part * (values[low + 1] - values[low]) : values[low];
  });
}
