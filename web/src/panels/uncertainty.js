// Uncertainty: many histories with parameters from ranges; bands of the curves and percentiles of what they lead to.
import {Bands, RANGED, coarse} from "../bands.js";
import {Chart} from "../chart.js";
import {button, h, newId, table} from "../dom.js";
import {rampAndHold} from "../history.js";
import {rangeFault, rangesOf} from "../model.js";
import {judge} from "../judge.js";
import {S} from "../strings.js";
import {hint, toNumber} from "../text.js";

const U = S.uncertainty, FRACTIONS = [0.05, 0.5, 0.95], PIECE = 100;

export function uncertaintyPanel(page) {
  const fault = h("p", {class: "fault", role: "alert", id: "range_fault"}), status = h("p", {id: "speed", role: "status"});
  const inputs = {}, result = h("div", {id: "percentiles", class: "result"}), countId = newId();
  const count = h("select", {id: countId}, ...[1000, 5000, 20000].map((n) => h("option", {value: n}, String(n))));
  const charts = ["lambda_e", "G", "force"].map((name, i) => new Chart({title: S.curves[name], sync: "uncertainty",
    bands: [[2, 0]], series: [S.curves.low, S.curves.median, S.curves.high].map((label, k) =>
      ({label, colour: i, dash: false, width: k === 1 ? 2 : 1}))}));
  let run = 0;

  const input = (name, end) => {
    const symbol = S.muscle.symbols[name], box = h("input", {type: "text", inputmode: "decimal", autocomplete: "off",
      name: `range_${name}_${end}`, "aria-label": (end === 0 ? U.low : U.high)(symbol), "aria-describedby": "range_fault"});
    box.addEventListener("input", () => page.attempt("uncertainty", compute));
    return box;
  };
  const rows = RANGED.map((name) => {
    inputs[name] = [input(name, 0), input(name, 1)];
    const entry = page.law.table[page.law.index[name]];
    return [`${S.muscle.symbols[name]} [${S.muscle.units[entry.unit]}]`, ...inputs[name]];
  });

  const numberIn = (box) => toNumber(box.value.trim());

  /** Takes the ranges from the page if all are right; else says what is wrong with the first. */
  function check() {
    for (const pair of Object.values(inputs)) pair.forEach((box) => box.setAttribute("aria-invalid", "false"));
    const say = (text, box) => {
      fault.textContent = text;
      box.setAttribute("aria-invalid", "true");
      return false;
    };
    const given = {}, label = (name, end) => [U.low, U.high][end](S.muscle.symbols[name]);
    for (const name of RANGED) {
      for (const [end, box] of inputs[name].entries()) {
        const text = box.value.trim();
        if (Number.isNaN(toNumber(text))) return say(S.expected(label(name, end), S.anyNumber, text, hint(text)), box);
      }
      given[name] = inputs[name].map(numberIn);
    }
    const wrong = rangeFault(page.law, page.model.muscle, given);
    if (wrong) return say(`${label(wrong.name, wrong.end)}: ${wrong.text}`, inputs[wrong.name][wrong.end]);
    fault.textContent = "";
    const follow = rangesOf(page.model);
    if (page.model.ranges || RANGED.some((name) => given[name].some((x, k) => x !== follow[name][k]))) page.model.ranges = given;
    page.keep();
    return true;
  }

  function show() {
    const ranges = rangesOf(page.model);
    for (const name of RANGED) inputs[name].forEach((box, k) => { box.value = String(ranges[name][k]); });
    check();
  }

  function finish(bands) {
    charts.forEach((chart, i) => chart.set(bands.points.time, bands.percentiles(["lambda_e", "G", "force"][i], FRACTIONS)));
    const judged = bands.runs.map((one) => judge(one, Infinity, 0.03));
    const texts = (number, digits) => bands.ofEach((_, i) => number(judged[i]), FRACTIONS)
      .map((x) => x === 0 ? U.always : isFinite(x) ? x.toFixed(digits) : U.never);
    result.replaceChildren(table(U.heading, U.columns, [[U.peak, ...texts((o) => o.peak, 4)],
      [U.returned, ...texts((o) => o.returned, 2)], [U.force, ...texts((o) => o.peakForce, 3)],
      [U.G, ...texts((o) => o.G, 4)]]));
  }

  function update() {
    if (!page.model.ranges) show(); // they follow the muscle
    compute();
  }

  function compute() {
    const mine = ++run;
    results.hidden = !check();
    if (results.hidden) return;
    const n = Number(count.value), points = coarse(rampAndHold(page.model.play));
    const bands = new Bands(page.law, page.model.muscle, rangesOf(page.model), points);
    let busy = 0;
    const later = () => setTimeout(() => mine === run && page.attempt("uncertainty", work));
    const work = () => {
      const started = performance.now();
      bands.add(Math.min(PIECE, n - bands.runs.length));
      busy += performance.now() - started;
      status.textContent = U.working(bands.runs.length, n);
      if (bands.runs.length < n) {
        later();
        return;
      }
      finish(bands);
      status.textContent = U.speed(n, busy);
    };
    later();
  }

  count.addEventListener("change", () => page.changed());
  const results = h("div", {}, status, result, h("div", {class: "charts"}, ...charts.map((c) => c.element)));
  const element = h("section", {"aria-label": U.heading}, h("h2", {}, U.heading), h("p", {}, U.explain),
    table(U.ranges, [U.parameter, U.from, U.to], rows), fault,
    h("div", {class: "row"}, h("label", {for: countId}, U.histories), count, button(U.run, () => page.changed()),
      button(U.follow, () => {
        page.model.ranges = null;
        page.changed();
      })), results);
  return {element, update, show, hide: () => { ++run; }};
}
