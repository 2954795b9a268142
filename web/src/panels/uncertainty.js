// Uncertainty: many histories with parameters from ranges; bands of the curves and percentiles of what they lead to.
import {Bands, RANGED, coarse} from "../bands.js";
import {Chart} from "../chart.js";
import {button, h, newId, table} from "../dom.js";
import {rampAndHold} from "../history.js";
import {rangesOf} from "../model.js";
import {judge} from "../judge.js";
import {hint, textOf, toNumber} from "../rows.js";
import {S} from "../strings.js";

const U = S.uncertainty, FRACTIONS = [0.05, 0.5, 0.95], PIECE = 100;

export function uncertaintyPanel(page) {
  const fault = h("p", {class: "fault", role: "alert", id: "range_fault"}), status = h("p", {id: "speed", role: "status"});
  const inputs = {}, result = h("div", {id: "percentiles"}), countId = newId();
  const count = h("select", {id: countId}, ...[1000, 5000, 20000].map((n) => h("option", {value: n}, String(n))));
  const charts = ["lambda_e", "G", "force"].map((name, i) => new Chart({title: S.curves[name], sync: "uncertainty",
    bands: [[2, 0]], series: [S.curves.low, S.curves.median, S.curves.high].map((label, k) =>
      ({label, colour: i, dash: false, width: k === 1 ? 2 : 1}))}));
  let run = 0;

  const input = (name, end) => {
    const symbol = S.muscle.symbols[name], box = h("input", {type: "text", inputmode: "decimal", autocomplete: "off",
      name: `range_${name}_${end}`, "aria-label": (end === 0 ? U.low : U.high)(symbol), "aria-describedby": "range_fault"});
    box.addEventListener("input", () => {
      if (check()) update();
    });
    return box;
  };
  const rows = RANGED.map((name) => {
    inputs[name] = [input(name, 0), input(name, 1)];
    const entry = page.law.table[page.law.index[name]];
    return [`${S.muscle.symbols[name]} [${S.muscle.units[entry.unit]}]`, ...inputs[name]];
  });

  /** Takes the ranges from the page if all are right; else says what is wrong with the first. */
  function check() {
    for (const pair of Object.values(inputs)) pair.forEach((box) => box.setAttribute("aria-invalid", "false"));
    const say = (text, box) => {
      fault.textContent = text;
      box.setAttribute("aria-invalid", "true");
      return false;
    };
    for (const name of RANGED) {
      const symbol = S.muscle.symbols[name], pair = inputs[name].map((box) => toNumber(box.value.trim()));
      for (const k of [0, 1]) {
        const box = inputs[name][k], label = [U.low, U.high][k](symbol), text = box.value.trim();
        if (Number.isNaN(pair[k])) return say(S.expected(label, S.anyNumber, text, hint(text)), box);
        const wrong = page.law.fault(Object.assign({}, page.model.muscle, {[name]: pair[k]}));
        if (wrong) return say(`${label}: ${wrong.text}`, box);
      }
      if (pair[0] > pair[1]) return say(U.order(symbol, pair[0], pair[1]), inputs[name][0]);
    }
    fault.textContent = "";
    const own = {}, follow = rangesOf(page.model);
    for (const name of RANGED) own[name] = inputs[name].map((box) => toNumber(box.value.trim()));
    if (page.model.ranges || RANGED.some((name) => own[name].some((x, k) => x !== follow[name][k]))) page.model.ranges = own;
    page.keep();
    return true;
  }

  function show() {
    const ranges = rangesOf(page.model);
    for (const name of RANGED) inputs[name].forEach((box, k) => { box.value = textOf(ranges[name][k]); });
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
    if (fault.textContent) return;
    const mine = ++run, n = Number(count.value), points = coarse(rampAndHold(page.model.play));
    const bands = new Bands(page.law, page.model.muscle, rangesOf(page.model), points);
    let busy = 0;
    const work = () => {
      if (mine !== run) return;
      const started = performance.now();
      bands.add(Math.min(PIECE, n - bands.runs.length));
      busy += performance.now() - started;
      status.textContent = U.working(bands.runs.length, n);
      if (bands.runs.length < n) {
        setTimeout(work);
        return;
      }
      finish(bands);
      status.textContent = U.speed(n, busy);
    };
    setTimeout(work);
  }

  count.addEventListener("change", update);
  const element = h("section", {"aria-label": U.heading}, h("h2", {}, U.heading), h("p", {}, U.explain),
    table(U.ranges, [U.parameter, U.from, U.to], rows), fault,
    h("div", {class: "row"}, h("label", {for: countId}, U.histories), count, button(U.run, update), button(U.follow, () => {
      page.model.ranges = null;
      page.changed();
    })), status,
    result, h("div", {class: "charts"}, ...charts.map((c) => c.element)));
  return {element, update, show, hide: () => { ++run; }};
}
