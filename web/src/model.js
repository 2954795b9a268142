// All inputs of the page, and their way into the fragment of the address and back.
import {PARAMETERS} from "./law.js";
import {PRESETS} from "./presets.js";
import {toNumber, textOf} from "./rows.js";
import {S} from "./strings.js";

export const TABS = ["play", "compare", "design", "uncertainty", "fit"];

export const EXAMPLES = [
  `title, ${S.compare.example}\nrest_length, 100\ndistract, 1, 8\nhold, 34\n`,
  `title, ${S.compare.stepExample}\nstep, 1.08\nhold, 42\n`,
];

export function paper() {
  const elastic = {c1: 16, c2: 4}, off = {tau_rev: 0, gamma_rev: 2, G_min: 0.5, lambda_crit_rev: 1};
  return Object.assign({}, elastic, PRESETS[0].values, off);
}

export function defaults() {
  return {
    tab: "play", muscle: paper(),
    play: {stretch: 1.1, ramp: 1, hold: 42, days: 42},
    ranges: null,
    programmes: EXAMPLES.slice(),
    compare: {limit: 1.05, within: 0.03},
    design: {target: 1.1, limit: 1.05, rest: 100},
    fit: {data: "", rest: 1, tau: [0.05, 5], lambda_crit: [0.98, 1.04]},
  };
}

/**
 * The ranges of the uncertain parameters: the user's own, else around the muscle's values as ./run sensitivity takes them
 * around the paper's, half of each and a hundredth for lambda_crit: an assumption.
 */
export function rangesOf(model) {
  if (model.ranges) return model.ranges;
  const half = (x, from = 0) => [from + 0.5 * (x - from), from + 1.5 * (x - from)].map((y) => Number(y.toPrecision(6)));
  const m = model.muscle;
  return {tau: half(m.tau), gamma: half(m.gamma), G_max: half(m.G_max, 1),
    lambda_crit: [m.lambda_crit - 0.01, m.lambda_crit + 0.01].map((y) => Number(Math.max(y, m.lambda_crit_rev * (m.tau_rev > 0))
      .toPrecision(6))), c1: half(m.c1), c2: half(m.c2)};
}

/** What plain numbers may be, [least, most], by their key in the link. */
export const ALLOWED = {
  stretch: ["play", "stretch", 0.5, 3], ramp: ["play", "ramp", 0, 3650], hold: ["play", "hold", 0, 3650],
  days: ["play", "days", 0.1, 3650],
  limit: ["compare", "limit", 0.5, 10], within: ["compare", "within", 0, 1],
  target: ["design", "target", 1.000001, 10], design_limit: ["design", "limit", 0.5, 10],
  rest: ["design", "rest", 0.001, 1e6], fit_rest: ["fit", "rest", 1e-3, 1e3],
};

/** The model as the fragment of an address. */
export function toFragment(model) {
  const q = new URLSearchParams();
  q.set("tab", model.tab);
  for (const name of PARAMETERS) q.set(name, textOf(model.muscle[name]));
  for (const [key, [group, name]] of Object.entries(ALLOWED)) q.set(key, textOf(model[group][name]));
  if (model.ranges) {
    for (const [name, pair] of Object.entries(model.ranges)) q.set(`range_${name}`, pair.map(textOf).join(":"));
  }
  for (const name of ["tau", "lambda_crit"]) q.set(`fit_${name}`, model.fit[name].map(textOf).join(":"));
  for (const text of model.programmes) q.append("programme", text);
  if (model.fit.data) q.set("fit_data", model.fit.data);
  return q.toString();
}

/** The model of a fragment; faults: what was wrong with it, entry by entry, whose defaults stay. */
export function fromFragment(fragment, law) {
  const model = defaults(), faults = [], q = new URLSearchParams(fragment);
  const refuse = (key, value, expected) => faults.push(S.linkEntry(key, value.slice(0, 60), expected));
  const programmes = q.getAll("programme");
  if (programmes.length > 0) model.programmes = programmes.slice(0, 4);
  if (programmes.length > 4) refuse("programme", programmes[4].split("\n")[0], S.compare.full);
  const pair = (key, value, into) => {
    const [low, high, ...more] = value.split(":").map(toNumber);
    if (low <= high && more.length === 0) into([low, high]);
    else refuse(key, value, "LOW:HIGH");
  };
  const muscle = Object.assign({}, model.muscle), ranges = {};
  for (const [key, value] of q) {
    const x = toNumber(value), range = /^(range|fit)_(\w+)$/.exec(key);
    if (key === "tab") {
      if (TABS.includes(value)) model.tab = value; else refuse(key, value, TABS.join(", "));
    } else if (PARAMETERS.includes(key)) {
      if (Number.isNaN(x)) refuse(key, value, S.anyNumber); else muscle[key] = x;
    } else if (ALLOWED[key]) {
      const [group, name, least, most] = ALLOWED[key];
      if (x >= least && x <= most) model[group][name] = x; else refuse(key, value, S.number(least, most));
    } else if (range && range[1] === "range" && rangesOf(model)[range[2]]) {
      pair(key, value, (both) => { ranges[range[2]] = both; });
    } else if (key === "fit_tau" || key === "fit_lambda_crit") {
      pair(key, value, (both) => { model.fit[range[2]] = both; });
    } else if (key === "fit_data") {
      model.fit.data = value;
    } else if (key !== "programme") {
      refuse(key, value, S.unknownEntry);
    }
  }
  const fault = law.fault(muscle);
  if (fault) faults.push(fault.text); else model.muscle = muscle;
  for (const [name, both] of Object.entries(ranges)) {
    const wrong = both.map((x) => law.fault(Object.assign({}, model.muscle, {[name]: x}))).find((f) => f);
    if (wrong) {
      faults.push(`range_${name}: ${wrong.text}`);
      delete ranges[name];
    }
  }
  if (Object.keys(ranges).length > 0) model.ranges = Object.assign(rangesOf(model), ranges);
  return {model, faults};
}
