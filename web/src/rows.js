// Rows of fields in a CSV file, in the rules and the words of examples/common/rows.hpp. A text is a string of bytes.

import {InputError, fromBytes, hint, textOf, toNumber, visible} from "./text.js";

const BLANK = " \t\v\f";

/** The rows of a file, one at a time. blanks: in rows with blanks between fields these separate them, not commas. */
export class Rows {
  constructor(name, bytes, blanks = false) {
    this.name = name;
    this.blanks = blanks;
    this.lineNumber = 0;
    if (/^(\xfe\xff|\xff\xfe)/.test(bytes)) throw new InputError(`${name}: is a file in UTF-16 or UTF-32; save it as UTF-8`);
    const nul = bytes.indexOf("\0");
    if (nul >= 0) {
      const before = bytes.slice(0, nul).split(/\r\n|\r|\n/);
      throw new InputError(`${name}:${before.length}:${before[before.length - 1].length + 1}: a NUL byte: this is a ` +
        "binary file, or UTF-16; expected a text in UTF-8");
    }
    this.lines = bytes.replace(/^\xef\xbb\xbf/, "").split(/\r\n|\r|\n/);
  }

  /** Goes to the next row that has fields; false if there is none. */
  next() {
    while (this.lineNumber < this.lines.length) {
      this.split(this.lines[this.lineNumber++]);
      if (this.fields.length > 0) return true;
    }
    return false;
  }

  split(whole) {
    const line = whole.split("#")[0];
    this.line = whole;
    this.fields = [];
    this.blankAfterComma = false;
    this.byBlanks = this.blanks && /[^\s,]\s+[^\s,]/.test(line);
    if (this.byBlanks) {
      for (const found of line.matchAll(/\S+/g)) this.fields.push({text: found[0], at: found.index});
      return;
    }
    for (let from = 0; from <= line.length;) {
      let begin = from;
      while (begin < line.length && BLANK.includes(line[begin])) ++begin;
      let end = line.indexOf(",", begin);
      if (end < 0) end = line.length;
      let stop = end;
      while (stop > begin && BLANK.includes(line[stop - 1])) --stop;
      this.fields.push({text: line.slice(begin, stop), at: begin});
      if (from > 0 && begin > from && begin < end) this.blankAfterComma = true;
      from = end + 1;
    }
    while (this.fields.length > 0 && this.fields[this.fields.length - 1].text === "") this.fields.pop();
  }

  get size() { return this.fields.length; }

  /** FILE:LINE:COLUMN of field i, or of the row's end. */
  place(i) {
    const last = this.fields[this.fields.length - 1];
    const at = i < this.size ? this.fields[i].at : last ? last.at + last.text.length : 0;
    const column = 1 + this.line.slice(0, at).replace(/[\x80-\xbf]/g, "").length;
    return `${this.name}:${this.lineNumber}:${column}`;
  }

  fail(i, words) {
    const error = new InputError(`${this.place(i)}: ${words}`);
    Object.assign(error, {row: this.lineNumber - 1, field: i, words});
    throw error;
  }

  unexpected(i, what) {
    if (i >= this.size || this.fields[i].text === "") this.fail(i, `expected ${what}, found nothing`);
    const found = this.fields[i].text;
    this.fail(i, `expected ${what}, found '${visible(found)}'${this.decimalComma(Math.max(i - 1, 0)) || hint(found)}`);
  }

  text(i, what) {
    if (i >= this.size || this.fields[i].text === "") this.unexpected(i, what);
    return this.fields[i].text;
  }

  /** All from field i to the end of the row, a text for people. */
  textFrom(i, what) {
    this.text(i, what);
    const last = this.fields[this.size - 1], whole = this.line.slice(this.fields[i].at, last.at + last.text.length);
    const refuse = () => this.fail(i, `expected ${what} in UTF-8 without control characters, found '${visible(whole)}'`);
    if (/[\0-\x08\x0a-\x1f\x7f]/.test(whole)) refuse(); // eslint-disable-line no-control-regex
    try {
      return fromBytes(whole);
    } catch (e) {
      return refuse();
    }
  }

  /** Field i, a number that is allowed. */
  numberIf(i, what, allowed) {
    const x = i < this.size ? toNumber(this.fields[i].text) : NaN;
    if (Number.isNaN(x) || !allowed(x)) this.unexpected(i, what);
    if (this.blankAfterComma && this.decimalComma(i)) {
      const whole = this.fields[i].text, part = this.fields[i + 1].text;
      this.fail(i, `two numbers or one? write '${whole}, ${part}' or '${whole}.${part}'`);
    }
    return x;
  }

  number(i, what, above = -Infinity) {
    return this.numberIf(i, `${what}, a number${isFinite(above) ? ` > ${textOf(above)}` : ""}`, (x) => x > above);
  }

  numberFrom(i, what, least, most) {
    return this.numberIf(i, `${what}, a number from ${textOf(least)} to ${textOf(most)}`, (x) => x >= least && x <= most);
  }

  numberWithin(i, what, [least, most]) {
    const x = this.number(i, what, 0);
    if (!(least <= x && x <= most)) this.unexpected(i, `${what} from ${textOf(least)} to ${textOf(most)}`);
    return x;
  }

  endsAfter(n) {
    if (this.size > n) this.unexpected(n, "the end of the row");
  }

  /** What to say of fields i and i + 1 if they look like one number with a decimal comma. */
  decimalComma(i) {
    if (this.byBlanks || i + 1 >= this.size) return "";
    const whole = this.fields[i], part = this.fields[i + 1];
    if (!/^[+-]*\d+$/.test(whole.text) || !/^\d+$/.test(part.text) || part.at !== whole.at + whole.text.length + 1)
      return "";
    return `: decimal comma? write ${whole.text}.${part.text}`;
  }
}
