// The rows of a history, and the history that they make: step, ramp, hold, distract, cycle, and the page's repeat.
import {LIMITS} from "./history.js";
import {S} from "./strings.js";
import {textOf} from "./text.js";

export class Moves {
  constructor(study, own) {
    Object.assign(this, {study, own});
  }

  add(rows, field, stretch, days) {
    const last = this.study.knots[this.study.knots.length - 1], [least, most] = LIMITS.stretch;
    if (!(stretch >= least && stretch <= most))
      rows.fail(field, `leads to stretch ${textOf(stretch)}: expected ${textOf(least)} to ${textOf(most)}`);
    if (last.time + days > LIMITS.days[1])
      rows.fail(rows.size - 1, `leads to day ${textOf(last.time + days)}: expected at most ${textOf(LIMITS.days[1])}`);
    if (this.study.knots.length > LIMITS.steps) rows.fail(0, S.tooManySteps(LIMITS.steps));
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

  /** Reads a row; false if its keyword is another. */
  row(rows, key) {
    const study = this.study;
    const days = (i) => rows.numberWithin(i, "a time in days", LIMITS.days);
    const stretch = () => rows.numberWithin(1, "a stretch", LIMITS.stretch);
    const go = (move, n) => {
      this.move(rows, move);
      rows.endsAfter(n);
      study.moves.push(move);
    };
    if (key === "step") {
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
      const d = rows.numberWithin(4, "a time in days", [c, LIMITS.days[1]]), cycles = Math.round(d / c);
      if (!(b < 24 * c)) rows.fail(2, `expected less than EVERY, ${textOf(24 * c)} hours, found ${textOf(b)}`);
      rows.endsAfter(5);
      if (Math.abs(cycles * c - d) > 1e-9 * d)
        rows.fail(4, `expected a multiple of EVERY, ${textOf(c)} days, found ${textOf(d)}`);
      if (cycles > LIMITS.cycles) rows.fail(4, `expected at most ${LIMITS.cycles} cycles, found ${textOf(cycles)}`);
      go({kind: "cycle", a, b, c, d, cycles}, 5);
    } else if (key === "repeat" && this.own) {
      this.repeat(rows);
    } else {
      return false;
    }
    return true;
  }

  repeat(rows) {
    const whole = (i, what, most) => rows.numberIf(i, `${what}, a whole number from 1 to ${most}`,
      (x) => Number.isInteger(x) && x >= 1 && x <= most);
    const moves = this.study.moves;
    if (moves.length === 0) rows.fail(0, "expected a row step, ramp, hold or distract before 'repeat'");
    const n = whole(1, "how many rows", moves.length), times = whole(2, "how many times", 1000);
    rows.endsAfter(3);
    if (moves.length + n * (times - 1) > LIMITS.rows) rows.fail(2, `more than ${LIMITS.rows} rows`);
    const some = moves.slice(-n);
    for (let i = 1; i < times; ++i) {
      for (const move of some) {
        this.move(rows, move);
        moves.push(move);
      }
    }
  }
}
