// The fastest admissible programme to a stretch, as ./run protocol --design plans it.
import {cut} from "./history.js";
import {S} from "./strings.js";
import {textOf} from "./text.js";

const MOST_DAYS = 36500, MOST_STEP_DAYS = 3650;

/** In daily steps: at the start of each day the stretch rises to the limit for the G of then. */
function dailySteps(law, muscle, limit, target) {
  const knots = [{time: 0, stretch: 1}];
  let G = 1;
  for (let day = 0; day < MOST_STEP_DAYS && knots[knots.length - 1].stretch < target; ++day) {
    const stretch = Math.min(target, Math.max(limit * G, knots[knots.length - 1].stretch));
    knots.push({time: day, stretch}, {time: day + 1, stretch});
    G = law.flow(muscle, G, stretch, 1);
  }
  return knots;
}

/** Days of the shortest ramp at a constant rate that stays within the limit; infinite: longer than `most`. */
function shortestRamp(law, muscle, limit, target, most) {
  const admissible = (days) => law.pull(muscle, cut([{time: 0, stretch: 1}, {time: days, stretch: target}], [], days / 400,
    0)).lambda_e.every((x) => x <= limit);
  if (!admissible(most)) return Infinity;
  let low = 0, high = most;
  while (high - low > 1e-4 * high) {
    const days = (low + high) / 2;
    if (admissible(days)) high = days; else low = days;
  }
  return high;
}

/** The plan {days, stepDays, rampDays, schedule, run, steps}; or {impossible: why}. */
export function design(law, muscle, {target, limit, rest}) {
  if (!(limit > muscle.lambda_crit) || !(limit > 1)) return {impossible: S.design.nothingGrows(limit, muscle.lambda_crit)};
  const ride = law.ride(muscle, limit), days = ride.day(target);
  if (!(days <= MOST_DAYS)) {
    return {impossible: target < limit * muscle.G_max ? S.design.tooLong(textOf(days), MOST_DAYS)
      : S.design.beyond(target, limit, muscle.G_max, textOf(target / muscle.G_max))};
  }
  const knots = [{time: 0, stretch: 1}, {time: 0, stretch: Math.min(limit, target)}], pieces = 400;
  for (let i = 1; i <= pieces && days > 0; ++i) {
    const t = days * (i / pieces) * (i / pieces);
    knots.push({time: t, stretch: limit * ride.G(t)});
  }
  const end = days + Math.max(days, 14), stepKnots = dailySteps(law, muscle, limit, target);
  const run = law.pull(muscle, cut(knots, [end], days > 0 ? days / 4000 : 0.01, 0.02));
  const steps = law.pull(muscle, cut(stepKnots, [end], 0.002, 0.02));
  const arrive = stepKnots[stepKnots.length - 1].stretch >= target;
  const stepDays = arrive ? stepKnots[stepKnots.length - 2].time : NaN;
  const schedule = [], lastDay = Math.ceil(Math.max(days, arrive ? stepDays : 0));
  let last = 0, lastStep = 0;
  for (let day = 0; day <= lastDay; ++day) {
    const a = Math.min(target, limit * ride.G(Math.min(day, days)));
    const b = stepKnots[Math.min(1 + 2 * day, stepKnots.length - 1)].stretch, mm = rest * (a - 1), stepMm = rest * (b - 1);
    schedule.push({day, stretch: a, mm, today: mm - last, stepStretch: b, stepMm, stepToday: stepMm - lastStep});
    last = mm;
    lastStep = stepMm;
  }
  const max = (values) => values.reduce((m, x) => Math.max(m, x), 0);
  return {days, stepDays, schedule, run, steps, peak: max(run.lambda_e), stepPeak: max(steps.lambda_e),
    rampDays: days > 0 ? shortestRamp(law, muscle, limit, target, 100 * days) : 0};
}
