// What a run says: peaks, time above a limit, the day of return; and the exact solution's numbers.
import {cut, halve} from "./history.js";

const crossing = (t0, t1, a, b, level) => t0 + (t1 - t0) * (level - a) / (b - a);

/** Peaks, days above the limit `injury` and the day from which lambda_e stays below 1 + within, as ./run protocol. */
export function judge(run, injury, within) {
  const level = 1 + within, n = run.time.length;
  const o = {lengthened: 0, peak: 0, peakDay: 0, above: 0, dose: 0, returned: 0, peakForce: 0, G: run.G[n - 1]};
  for (let i = 0; i < n; ++i) {
    const p = i > 0 ? i - 1 : 0, t0 = run.time[p], t1 = run.time[i], a = run.lambda_e[p], b = run.lambda_e[i];
    if (b > o.peak) {
      o.peak = b;
      o.peakDay = t1;
    }
    o.peakForce = Math.max(o.peakForce, run.force[i]);
    if (run.stretch[i] > run.stretch[p]) o.lengthened = t1;
    if (a > injury || b > injury) {
      const from = a < injury ? crossing(t0, t1, a, b, injury) : t0;
      const to = b < injury ? crossing(t0, t1, a, b, injury) : t1;
      o.above += to - from;
      o.dose += (to - from) * (Math.max(a - injury, 0) + Math.max(b - injury, 0)) / 2;
    }
    if (b > level) o.returned = Infinity;
    else if (a > level) o.returned = crossing(t0, t1, a, b, level);
  }
  return o;
}

/**
 * The exact solution of eq. 4 along the knots: peak of lambda_e, its day, and for every level the day from which
 * lambda_e stays below it (0: always, infinite: not within the history). The flow is exact where the stretch is held;
 * along ramps steps of two lengths are extrapolated.
 */
export function exact(law, muscle, knots, levels) {
  const coarse = cut(knots, [], 0.002, 0.05, 0.001);
  const one = law.pull(muscle, coarse), two = law.pull(muscle, halve(coarse));
  const n = coarse.time.length, G = one.G.map((g, i) => (4 * two.G[2 * i] - g) / 3);
  const lambda_e = G.map((g, i) => coarse.stretch[i] / g);
  let peak = 0;
  for (let i = 1; i < n; ++i) if (lambda_e[i] > lambda_e[peak]) peak = i;
  const returned = levels.map((level) => {
    let last = n - 1;
    while (last >= 0 && lambda_e[last] <= level) --last;
    if (last < 0) return 0;
    if (last === n - 1) return Infinity;
    const t0 = coarse.time[last], t1 = coarse.time[last + 1], held = coarse.stretch[last];
    if (t1 === t0) return t1;
    if (coarse.stretch[last + 1] !== held)
      return crossing(t0, t1, lambda_e[last], lambda_e[last + 1], level);
    let low = 0, high = t1 - t0;
    for (let i = 0; i < 60; ++i) {
      const dt = (low + high) / 2;
      if (held / law.flow(muscle, G[last], held, dt) > level) low = dt; else high = dt;
    }
    return t0 + high;
  });
  return {peak: lambda_e[peak], peakDay: coarse.time[peak], returned, G: G[n - 1], lambda_e: lambda_e[n - 1]};
}
