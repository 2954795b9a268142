// Histories of stretch: knots {time, stretch}, cut into time steps as examples/common/study.hpp does it.
import {S} from "./strings.js";
import {InputError} from "./text.js";

export const LIMITS = {days: [1e-6, 1e6], stretch: [0.01, 100], length: [1e-3, 1e6], measured: [1e-6, 1e3],
  rows: 100000, steps: 200000, cycles: 20000};

/**
 * The history with time steps between its knots. After every knot the steps begin with `first` [day] and lengthen by
 * `ratio` of the time since; none takes more than `most` of stretch. It ends at the last knot or stop.
 */
export function cut(knots, stops, first, ratio, most = 0.002) {
  const last = knots[knots.length - 1], ends = stops.slice().sort((a, b) => a - b), latest = ends[ends.length - 1];
  const all = latest > last.time ? knots.concat({time: latest, stretch: last.stretch}) : knots;
  const time = [all[0].time], stretch = [all[0].stretch];
  const push = (t, x) => {
    if (time.length > LIMITS.steps) throw new InputError(S.tooManySteps(LIMITS.steps));
    time.push(t);
    stretch.push(x);
  };
  for (let k = 1; k < all.length; ++k) {
    const a = all[k - 1], b = all[k], length = b.time - a.time, change = Math.abs(b.stretch - a.stretch);
    if (!(length > 0)) {
      push(b.time, b.stretch);
      continue;
    }
    const longest = change > 0 ? most * length / change : length;
    for (let t = a.time; t < b.time;) {
      let next = t + Math.min(first + ratio * (t - a.time), longest);
      if (next > b.time - 1e-9 * length) next = b.time;
      const from = t, stop = ends.find((s) => s > from);
      if (stop !== undefined && stop < next) next = stop;
      t = next;
      push(t, t === b.time ? b.stretch : a.stretch + (b.stretch - a.stretch) * (t - a.time) / length);
    }
  }
  return {time: Float64Array.from(time), stretch: Float64Array.from(stretch)};
}

/** The same with every step halved. */
export function halve(points) {
  const n = points.time.length, time = new Float64Array(2 * n - 1), stretch = new Float64Array(2 * n - 1);
  for (let i = 0; i < n; ++i) {
    time[2 * i] = points.time[i];
    stretch[2 * i] = points.stretch[i];
    if (i === 0) continue;
    time[2 * i - 1] = (points.time[i] + points.time[i - 1]) / 2;
    stretch[2 * i - 1] = (points.stretch[i] + points.stretch[i - 1]) / 2;
  }
  return {time, stretch};
}

/** Knots of a ramp to a stretch that is held and then released, until `days`. */
export function rampAndHold({stretch, ramp, hold, days}) {
  const knots = [{time: 0, stretch: 1}];
  if (ramp >= days) return knots.concat({time: days, stretch: 1 + (stretch - 1) * days / ramp});
  knots.push({time: ramp, stretch});
  if (ramp + hold < days) {
    knots.push({time: ramp + hold, stretch}, {time: ramp + hold, stretch: 1});
    return knots.concat({time: days, stretch: 1});
  }
  return knots.concat({time: days, stretch});
}

/** The value of a curve at a time, by straight lines; of two points of the same time the later one. */
export function valueAt(time, values, t) {
  let low = 0, high = time.length - 1;
  if (t >= time[high]) return values[high];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (time[middle] <= t) low = middle; else high = middle;
  }
  const dt = time[high] - time[low];
  return dt > 0 ? values[low] + (values[high] - values[low]) * (t - time[low]) / dt : values[high];
}

/** All times of some runs, increasing; one at which a run has a step, two values, is there twice. */
export function timesOf(all) {
  const twice = new Set();
  for (const time of all) time.forEach((t, i) => { if (i > 0 && time[i - 1] === t) twice.add(t); });
  const once = new Set();
  for (const time of all) time.forEach((t) => once.add(t));
  const times = [];
  for (const t of Float64Array.from(once).sort()) times.push(...(twice.has(t) ? [t, t] : [t]));
  return times;
}

/** A curve at such times: of a step, its first value at the first of the two times, and its last one at the second. */
export function along(times, time, values) {
  let k = 0;
  return times.map((t, i) => {
    while (k < time.length && time[k] < t) ++k;
    return times[i + 1] === t && time[k] === t ? values[k] : valueAt(time, values, t);
  });
}
