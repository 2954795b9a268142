// All inputs of the page, and their way into the fragment of the address and back.
import {PARAMETERS} from "./law.js";
import {PRESETS} from "./presets.js";
import {S} from "./strings.js";
import {toNumber} from "./text.js";

export const TABS = ["play", "compare", "design", "uncertainty", "fit"];

export const MOST_PROGRAMMES = 4, FITTED = ["tau", "lambda_crit"];

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
  // Six digits, unless rounding leaves what is allowed (G_max = 1 + 1e-15, 1e308).
  const round = (y, from) => {
    const x = Number(y.toPrecision(6));
    return isFinite(x) && (x > from || y <= from) ? x : Math.min(y, Number.MAX_VALUE);
  };
  const half = (x, from = 0) => [from + 0.5 * (x - from), from + 1.5 * (x - from)].map((y) => round(y, from));
  const m = model.muscle, least = Math.max(m.lambda_crit - 0.01, m.lambda_crit / 2, m.tau_rev > 0 ? m.lambda_crit_rev : 0);
  return {tau: half(m.tau), gamma: half(m.gamma), G_max: half(m.G_max, 1),
    lambda_crit: [round(Math.min(least, m.lambda_crit), 0), round(m.lambda_crit + 0.01, 0)], c1: half(m.c1), c2: half(m.c2)};
}

/** What is wrong with the ranges beside the muscle's other parameters, {name, end, text}; null if nothing is. */
export function rangeFault(law, muscle, ranges) {
  for (const [name, both] of Object.entries(ranges)) {
    for (const end of [0, 1]) {
      const fault = law.fault(Object.assign({}, muscle, {[name]: both[end]}));
      if (fault) return {name, end, text: fault.text};
    }
    if (both[0] > both[1]) return {name, end: 0, text: S.uncertainty.order(S.muscle.symbols[name], both[0], both[1])};
  }
  return null;
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
  for (const name of PARAMETERS) q.set(name, model.muscle[name]);
  for (const [key, [group, name]] of Object.entries(ALLOWED)) q.set(key, model[group][name]);
  if (model.ranges) {
    for (const [name, pair] of Object.entries(model.ranges)) q.set(`range_${name}`, pair.join(":"));
  }
  for (const name of FITTED) q.set(`fit_${name}`, model.fit[name].join(":"));
  for (const text of model.programmes) q.append("programme", text);
  if (model.fit.data) q.set("fit_data", model.fit.data);
  return q.toString();
}

/** The model of a fragment; faults: what was wrong with it, entry by entry, whose defaults stay. */
export function fromFragment(fragment, law) {
  const model = defaults(), faults = [], q = new URLSearchParams(fragment), seen = new Set();
  const refuse = (key, value, expected) => faults.push(S.linkEntry(key.slice(0, 60), value.slice(0, 60), expected));
  const programmes = q.getAll("programme");
  if (programmes.length > 0) model.programmes = programmes.slice(0, MOST_PROGRAMMES);
  if (programmes.length > MOST_PROGRAMMES) refuse("programme", programmes[MOST_PROGRAMMES].split("\n")[0], S.fourProgrammes);
  const pair = (key, value, into) => {
    const [low, high, ...more] = value.split(":").map(toNumber);
    if (low <= high && more.length === 0) into([low, high]);
    else refuse(key, value, "LOW:HIGH");
  };
  const muscle = Object.assign({}, model.muscle), follow = rangesOf(model), ranges = {}, fits = {};
  for (const [key, value] of q) {
    const x = toNumber(value), [, kind, name] = /^(range|fit)_(\w+)$/.exec(key) || [];
    if (seen.has(key) && key !== "programme") {
      refuse(key, value, S.givenTwice);
    } else if (key === "tab") {
      if (TABS.includes(value)) model.tab = value; else refuse(key, value, TABS.join(", "));
    } else if (PARAMETERS.includes(key)) {
      if (Number.isNaN(x)) refuse(key, value, S.anyNumber); else muscle[key] = x;
    } else if (Object.keys(ALLOWED).includes(key)) {
      const [group, member, least, most] = ALLOWED[key];
      if (x >= least && x <= most) model[group][member] = x; else refuse(key, value, S.number(least, most));
    } else if (kind === "range" && Object.keys(follow).includes(name)) {
      pair(key, value, (both) => { ranges[name] = both; });
    } else if (kind === "fit" && FITTED.includes(name)) {
      pair(key, value, (both) => { fits[name] = both; });
    } else if (key === "fit_data") {
      model.fit.data = value;
    } else if (key !== "programme") {
      refuse(key, value, S.unknownEntry);
    }
    seen.add(key);
  }
  const fault = law.fault(muscle);
  if (fault) faults.push(fault.text); else model.muscle = muscle;
  for (const [prefix, given] of [["range_", ranges], ["fit_", fits]]) {
    for (const [name, both] of Object.entries(given)) {
      const wrong = rangeFault(law, model.muscle, {[name]: both});
      if (wrong || (given === fits && !(both[0] < both[1]))) {
        faults.push(`${prefix}${name} = ${both.join(":")}: ${wrong ? wrong.text : S.linkOrder}`);
        delete given[name];
      }
    }
  }
  if (Object.keys(ranges).length > 0) model.ranges = Object.assign(rangesOf(model), ranges);
  Object.assign(model.fit, fits);
  return {model, faults};
}
