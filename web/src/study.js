// A study's file, as ./run protocol and ./run fit read it: rows with a keyword (examples/common/study.hpp), checked in
// the same words. One keyword is the page's own: `repeat, ROWS, TIMES`, the last ROWS rows of history TIMES times in all.
import {LIMITS} from "./history.js";
import {PARAMETERS} from "./law.js";
import {InputError, Rows, textOf, toBytes, visible} from "./rows.js";
import {S} from "./strings.js";

const FITTED = [...PARAMETERS.slice(2), "amplitude"];
const REMOVAL = ["gamma_rev", "G_min", "lambda_crit_rev"];
const KINDS = "title, include, set, fit, rest_length, step, ramp, hold, distract, cycle, tendon or measure";

/**
 * Reads a study. files: a Map of the names to the bytes of all files that it may include. own: take the page's rows too.
 * Returns {name, title, set, places, fitted, rest, knots, measurements, moves}.
 */
export function readStudy(files, name, own = false) {
  const study = {name: name.replace(/\.[^.]*$/, ""), title: "", set: {}, places: {}, fitted: [], rest: 0,
    knots: [{time: 0, stretch: 1}], measurements: [], moves: []};
  new Reader(study, files, own).file(name, []);
  if (!study.title) study.title = visible(study.name);
  return study;
}

/** readStudy of a text that is no file. */
export function readText(name, text, own = false) {
  return readStudy(new Map([[name, toBytes(text)]]), name, own);
}

class Reader {
  constructor(study, files, own) {
    Object.assign(this, {study, files, own, nRows: 0, before: new Map()});
  }

  file(name, chain) {
    const bytes = this.files.get(name);
    if (bytes === undefined) throw new InputError(`${name}: no such file`);
    const rows = new Rows(name, bytes);
    while (rows.next()) {
      if (++this.nRows > LIMITS.rows) rows.fail(0, `more than ${LIMITS.rows} rows, with those of included files`);
      this.row(rows, chain.concat(name));
    }
    if (this.nRows === 0) throw new InputError(`${name}: has no rows`);
  }

  include(rows, chain) {
    const name = rows.text(1, "the name of a file").split("/").pop();
    rows.endsAfter(2);
    const refuse = (why) => rows.fail(1, `expected the name of a file that can be read, found '${visible(name)}': ${why}`);
    if (chain.includes(name)) refuse(`a circle, ${chain.concat(name).join(" -> ")}`);
    if (!this.files.has(name)) refuse("it is not among the files here: drop or open both files together");
    this.file(name, chain);
  }

  /** Fails if the same has already been given. A row may replace one of a file that its own file has included. */
  once(rows, chain, what, mayReplace = true) {
    const first = this.before.get(what);
    if (first && (!mayReplace || first.depth <= chain.length)) rows.fail(0, `${what} was already given, in ${first.place}`);
    this.before.set(what, {place: rows.place(0), depth: chain.length});
  }

  add(rows, field, stretch, days) {
    const last = this.study.knots[this.study.knots.length - 1], [least, most] = LIMITS.stretch;
    if (!(stretch >= least && stretch <= most))
      rows.fail(field, `leads to stretch ${textOf(stretch)}: expected ${textOf(least)} to ${textOf(most)}`);
    if (last.time + days > LIMITS.days[1])
      rows.fail(rows.size - 1, `leads to day ${textOf(last.time + days)}: expected at most ${textOf(LIMITS.days[1])}`);
    this.study.knots.push({time: last.time + days, stretch});
  }

  /** A move of the history: what to do from where it is. */
  move(rows, move) {
    const last = this.study.knots[this.study.knots.length - 1];
    if (move.kind === "cycle") {
      for (let i = 0; i < move.cycles; ++i) {
        for (const [stretch, days] of [[move.a, 0], [move.a, move.b / 24], [last.stretch, 0],
          [last.stretch, move.c - move.b / 24]]) this.add(rows, 1, stretch, days);
      }
    } else if (move.kind === "distract")
      this.add(rows, 1, last.stretch + move.a * move.b / this.study.rest, move.b);
    else this.add(rows, 1, move.kind === "hold" ? last.stretch : move.a, move.days);
  }

  row(rows, chain) {
    const study = this.study;
    const within = (i, what, [least, most]) => {
      const x = rows.number(i, what, 0);
      if (!(least <= x && x <= most)) rows.unexpected(i, `${what} from ${textOf(least)} to ${textOf(most)}`);
      return x;
    };
    const days = (i) => within(i, "a time in days", LIMITS.days);
    const stretch = () => within(1, "a stretch", LIMITS.stretch);
    const go = (move, n) => {
      this.move(rows, move);
      rows.endsAfter(n);
      study.moves.push(move);
    };
    const key = rows.text(0, "a keyword");
    if (key === "title") {
      this.once(rows, chain, "the title");
      study.title = rows.textFrom(1, "a text");
    } else if (key === "include") {
      this.include(rows, chain);
    } else if (key === "set") {
      const name = rows.text(1, "the name of a parameter");
      if (!PARAMETERS.includes(name)) rows.unexpected(1, `a parameter: ${PARAMETERS.join(", ")}`);
      study.set[name] = rows.number(2, "a value");
      rows.endsAfter(3);
      this.once(rows, chain, `set, ${name}`);
      study.places[name] = rows.place(2);
    } else if (key === "fit") {
      const name = rows.text(1, "the name of a parameter");
      if (!FITTED.includes(name)) rows.unexpected(1, FITTED.join(", ").replace(/, (\w+)$/, " or $1"));
      const lower = rows.number(2, "a lower bound"), upper = rows.number(3, "an upper bound", lower);
      rows.endsAfter(4);
      this.once(rows, chain, `fit, ${name}`);
      study.fitted = study.fitted.filter((b) => b.name !== name).concat({name, lower, upper, place: rows.place(0)});
    } else if (key === "rest_length") {
      study.rest = within(1, "a length in mm", LIMITS.length);
      rows.endsAfter(2);
      this.once(rows, chain, "rest_length");
    } else if (key === "step") {
      go({kind: "step", a: stretch(), days: 0}, 2);
    } else if (key === "ramp") {
      const a = stretch(), b = days(2);
      go({kind: "ramp", a, b, days: b}, 3);
    } else if (key === "hold") {
      const a = days(1);
      go({kind: "hold", a, days: a}, 2);
    } else if (key === "distract") {
      if (!(study.rest > 0)) rows.fail(0, "expected a row 'rest_length, MM' before 'distract'");
      const a = rows.number(1, "a rate in mm/day"), b = days(2);
      rows.endsAfter(3);
      go({kind: "distract", a, b, days: b}, 3);
    } else if (key === "cycle") {
      const a = stretch(), b = rows.number(2, "a time in hours", 0), c = days(3);
      const d = within(4, "a time in days", [c, LIMITS.days[1]]), cycles = Math.round(d / c);
      if (!(b < 24 * c)) rows.fail(2, `expected less than EVERY, ${textOf(24 * c)} hours, found ${textOf(b)}`);
      rows.endsAfter(5);
      if (Math.abs(cycles * c - d) > 1e-9 * d)
        rows.fail(4, `expected a multiple of EVERY, ${textOf(c)} days, found ${textOf(d)}`);
      if (cycles > LIMITS.cycles) rows.fail(4, `expected at most ${LIMITS.cycles} cycles, found ${textOf(cycles)}`);
      go({kind: "cycle", a, b, c, d, cycles}, 5);
    } else if (key === "tendon") {
      rows.fail(0, S.noTendon);
    } else if (key === "repeat" && this.own) {
      this.repeat(rows);
    } else if (key === "measure") {
      const time = rows.numberFrom(1, "a time in days", 0, LIMITS.days[1]), quantity = rows.text(2, "lambda_e, G or tendon");
      if (!["lambda_e", "G", "tendon"].includes(quantity)) rows.unexpected(2, "lambda_e, G or tendon");
      if (quantity === "tendon") rows.fail(2, S.noTendon);
      const value = within(3, "a value", LIMITS.measured), sd = within(4, "a standard deviation", LIMITS.measured);
      rows.endsAfter(5);
      this.once(rows, chain, `the measurement of ${quantity} = ${textOf(value)} on day ${textOf(time)}`, false);
      study.measurements.push({time, quantity, value, sd});
    } else {
      rows.unexpected(0, this.own ? KINDS.replace("tendon or", "tendon, repeat or") : KINDS);
    }
  }

  repeat(rows) {
    const whole = (i, what, most) => rows.numberIf(i, `${what}, a whole number from 1 to ${most}`,
      (x) => Number.isInteger(x) && x >= 1 && x <= most);
    const moves = this.study.moves;
    if (moves.length === 0) rows.fail(0, "expected a row step, ramp, hold or distract before 'repeat'");
    const n = whole(1, "how many rows", moves.length), times = whole(2, "how many times", 1000);
    rows.endsAfter(3);
    if (n * times > LIMITS.rows) rows.fail(2, `more than ${LIMITS.rows} rows`);
    const some = moves.slice(-n);
    for (let i = 1; i < times; ++i) {
      for (const move of some) {
        this.move(rows, move);
        moves.push(move);
      }
    }
  }
}

/** The muscle of a study: the paper's or the page's parameters, and what the study sets; checked together. */
export function muscleOf(law, study, otherwise) {
  const muscle = Object.assign({}, otherwise, study.set), place = (name) => study.places[name] || study.name;
  const fault = law.fault(muscle);
  if (fault) throw new InputError(`${place(fault.symbol)}: ${fault.text}`);
  if (study.set.tau_rev > 0) {
    for (const name of REMOVAL) {
      if (study.set[name] === undefined)
        throw new InputError(`${place("tau_rev")}: tau_rev = ${textOf(study.set.tau_rev)}: expected ${name} to be set too, ` +
          "as all of removal's parameters");
    }
  }
  return muscle;
}

/** A study as a file that ./run protocol reads: repeated rows are written out. */
export function csvOf(study) {
  const lines = [`title, ${study.title}`];
  for (const name of PARAMETERS) if (study.set[name] !== undefined) lines.push(`set, ${name}, ${study.set[name]}`);
  if (study.rest > 0) lines.push(`rest_length, ${study.rest}`);
  for (const m of study.moves) lines.push([m.kind, m.a, m.b, m.c, m.d].filter((x) => x !== undefined).join(", "));
  return lines.join("\n") + "\n";
}
