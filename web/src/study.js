// A study's file, as ./run protocol and ./run fit read it: rows with a keyword (examples/common/study.hpp), checked in
// the same words. One keyword is the page's own: `repeat, ROWS, TIMES`, the last ROWS rows of history TIMES times in all.
import {LIMITS} from "./history.js";
import {PARAMETERS} from "./law.js";
import {Moves} from "./moves.js";
import {Rows} from "./rows.js";
import {S} from "./strings.js";
import {InputError, textOf, toBytes, visible} from "./text.js";

const FITTED = [...PARAMETERS.slice(2), "amplitude"];
const KINDS = "title, include, set, fit, rest_length, step, ramp, hold, distract, cycle, tendon or measure";

/** A study without rows. The title of a file without one is its name; in a row, # would begin a comment. */
function empty(name) {
  const stem = name.replace(/\.[^.]*$/, "");
  return {name: stem, title: "", set: {}, places: {}, fitted: [], rest: 0, knots: [{time: 0, stretch: 1}], measurements: [],
    moves: [], otherTitle: stem.replace(/[#\0-\x1f\x7f]/g, "_")}; // eslint-disable-line no-control-regex
}

/**
 * Reads a study. files: a Map of the names to the bytes of all files that it may include. own: take the page's rows too.
 * Returns {name, title, set, places, fitted, rest, knots, measurements, moves}.
 */
export function readStudy(files, name, own = false) {
  const study = empty(name);
  new Reader(study, files, own).file(name, []);
  study.title = study.title || study.otherTitle;
  return study;
}

/** readStudy of a text that is no file. */
export function readText(name, text, own = false) {
  return readStudy(new Map([[name, toBytes(text)]]), name, own);
}

/** Measurements of lambda_e as rows of day, value, standard deviation, without keywords. */
export function readPlain(name, text) {
  const study = empty(name), reader = new Reader(study, new Map(), false), rows = new Rows(name, toBytes(text), true);
  while (rows.next()) reader.measurement(rows, [name], 0, "lambda_e");
  if (study.measurements.length === 0) throw new InputError(`${name}: has no rows`);
  return study;
}

/** The name of the file that a row includes; "" if it includes none. Folders are not known to a page. */
export function includedBy(rows) {
  return rows.size > 1 && rows.text(0, "") === "include" ? rows.textFrom(1, "the name of a file").split("/").pop() : "";
}

class Reader {
  constructor(study, files, own) {
    Object.assign(this, {study, files, own, nRows: 0, before: new Map(), moves: new Moves(study, own)});
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
    rows.text(1, "the name of a file");
    rows.endsAfter(2);
    const name = includedBy(rows);
    const refuse = (why) => rows.fail(1, "expected the name of a file that can be read, found " +
      `'${visible(rows.text(1, ""))}': ${why}`);
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

  /** A measurement whose day is in field i; value and deviation are the last two of its row. */
  measurement(rows, chain, i, quantity) {
    const time = rows.numberFrom(i, "a time in days", 0, LIMITS.days[1]), at = i === 0 ? 1 : 3;
    const [value, sd] = ["a value", "a standard deviation"].map((what, k) => rows.numberWithin(at + k, what, LIMITS.measured));
    rows.endsAfter(at + 2);
    this.once(rows, chain, `the measurement of ${quantity} = ${textOf(value)} on day ${textOf(time)}`, false);
    this.study.measurements.push({time, quantity, value, sd});
  }

  row(rows, chain) {
    const study = this.study;
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
      study.rest = rows.numberWithin(1, "a length in mm", LIMITS.length);
      rows.endsAfter(2);
      this.once(rows, chain, "rest_length");
    } else if (this.moves.row(rows, key)) {
      return;
    } else if (key === "tendon") {
      rows.fail(0, S.noTendon);
    } else if (key === "measure") {
      rows.numberFrom(1, "a time in days", 0, LIMITS.days[1]);
      const quantity = rows.text(2, "lambda_e, G or tendon");
      if (!["lambda_e", "G", "tendon"].includes(quantity)) rows.unexpected(2, "lambda_e, G or tendon");
      if (quantity === "tendon") rows.fail(2, S.noTendon);
      this.measurement(rows, chain, 1, quantity);
    } else {
      rows.unexpected(0, this.own ? KINDS.replace("tendon or", "tendon, repeat or") : KINDS);
    }
  }
}
