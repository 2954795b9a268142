// Fit: tau and lambda_crit from measured sarcomere lengths, with intervals.
import {Chart} from "../chart.js";
import {button, h, newId, table} from "../dom.js";
import {Fit, PARAMETERS_OF_FIT, checkFit} from "../fit.js";
import {cut, rampAndHold} from "../history.js";
import {InputError, hint, textOf, toBytes, toNumber} from "../rows.js";
import {muscleOf, readStudy} from "../study.js";
import {S} from "../strings.js";
import {EXAMPLE} from "./fit_example.js";
import {modelField} from "./play.js";

const F = S.fit, KEYWORDS = /^\s*(title|include|set|fit|rest_length|step|ramp|hold|distract|measure)\s*(,|$)/m;

/** The rows as a study. Rows without keywords are day, value, sd; they get the history of the tab Play. */
function studyOf(page, text) {
  const {rest} = page.model.fit, plain = !KEYWORDS.test(text);
  const rows = text.split("\n").map((line) => {
    const [fields] = line.split("#");
    if (!fields.trim()) return line;
    const parts = fields.split(/[,;\t]/).length > 1 || !plain ? fields : fields.trim().split(/\s+/).join(", ");
    const [day, ...more] = parts.split(",");
    return plain ? `measure, ${day.trim()}, lambda_e,${more.join(",")}` : line;
  });
  const study = readStudy(new Map([[F.file, toBytes(rows.join("\n"))]]), F.file, true);
  if (study.knots.length < 2) study.knots = rampAndHold(page.model.play);
  for (const m of study.measurements) {
    if (m.quantity !== "lambda_e") continue;
    m.value /= rest;
    m.sd /= rest;
  }
  return study;
}

export function fitPanel(page) {
  const dataId = newId(), faultId = newId();
  const data = h("textarea", {id: dataId, name: "fit_data", rows: 12, spellcheck: "false", "aria-describedby": faultId});
  const fault = h("p", {class: "fault", role: "alert", id: faultId}), result = h("div", {id: "fit_result",
    "aria-live": "polite"});
  const rest = modelField(page, "fit_rest", F.rest, F.restUnit), bounds = {};
  const chart = new Chart({title: S.curves.lambda_e, series: [{label: F.law, colour: 0},
    {label: F.measured, colour: 1, points: true}]});
  chart.element.hidden = true;
  const boundRows = PARAMETERS_OF_FIT.map((name) => {
    bounds[name] = [0, 1].map((k) => h("input", {type: "text", inputmode: "decimal", name: `fit_${name}_${k}`,
      autocomplete: "off", "aria-label": [S.uncertainty.low, S.uncertainty.high][k](S.muscle.symbols[name]),
      oninput: () => takeBounds()}));
    return [S.muscle.symbols[name], ...bounds[name]];
  });

  function takeBounds() {
    fault.textContent = "";
    for (const name of PARAMETERS_OF_FIT) {
      const symbol = S.muscle.symbols[name], pair = bounds[name].map((box) => toNumber(box.value.trim()));
      for (const k of [0, 1]) {
        const text = bounds[name][k].value.trim(), label = [S.uncertainty.low, S.uncertainty.high][k](symbol);
        if (Number.isNaN(pair[k])) fault.textContent = S.expected(label, S.anyNumber, text, hint(text));
        const wrong = !fault.textContent && page.law.fault(Object.assign({}, page.model.muscle, {[name]: pair[k]}));
        if (wrong) fault.textContent = `${label}: ${wrong.text}`;
        if (fault.textContent) return false;
      }
      if (!(pair[0] < pair[1])) {
        fault.textContent = S.uncertainty.order(symbol, pair[0], pair[1]);
        return false;
      }
    }
    for (const name of PARAMETERS_OF_FIT) page.model.fit[name] = bounds[name].map((box) => toNumber(box.value.trim()));
    page.keep();
    return true;
  }

  function show() {
    rest.show();
    if (data.value !== page.model.fit.data) data.value = page.model.fit.data;
    for (const name of PARAMETERS_OF_FIT) bounds[name].forEach((box, k) => { box.value = textOf(page.model.fit[name][k]); });
  }

  function compute() {
    result.replaceChildren();
    chart.element.hidden = true;
    if (!takeBounds()) return;
    try {
      const study = studyOf(page, data.value);
      checkFit(study);
      const muscle = muscleOf(page.law, study, page.model.muscle), ranges = {};
      for (const name of PARAMETERS_OF_FIT) {
        const given = study.fitted.find((b) => b.name === name);
        ranges[name] = given ? [given.lower, given.upper] : page.model.fit[name];
      }
      const fit = new Fit(page.law, muscle, study.knots, study.measurements, ranges);
      const found = fit.best(PARAMETERS_OF_FIT.map((name) => muscle[name]));
      page.fitted = found;
      report(found, ranges);
      draw(fit, found, study, muscle);
    } catch (e) {
      if (!(e instanceof InputError)) throw e;
      fault.textContent = e.message;
    }
  }

  function report(found, ranges) {
    const end = (x) => isFinite(x) ? x.toPrecision(5) : F.open;
    const notes = [];
    for (const p of found.parameters) {
      if (p.atBound) notes.push(F.atBound(S.muscle.symbols[p.name]));
      if (!isFinite(p.lower) || !isFinite(p.upper)) notes.push(F.unbounded(S.muscle.symbols[p.name]));
    }
    const freedom = found.n - 2;
    if (found.n < 3) notes.push(F.few);
    if (found.agreeing === 1) notes.push(F.one);
    if (freedom > 0 && found.chi2 > freedom + 3 * Math.sqrt(2 * freedom)) notes.push(F.misses(found.chi2, freedom));
    result.replaceChildren(table(F.heading, F.columns, found.parameters.map((p) => [S.muscle.symbols[p.name], end(p.estimate),
      end(p.sd), F.interval(end(p.low), end(p.high)), F.interval(end(p.lower), end(p.upper)),
      F.interval(...ranges[p.name].map(textOf))])), h("p", {}, F.sum(found.n, found.chi2, found.agreeing, found.starts)),
    ...notes.map((text) => h("p", {class: "warning"}, text)), button(F.use, () => {
      for (const p of found.parameters) page.model.muscle[p.name] = Number(p.estimate.toPrecision(6));
      page.changed();
      page.showAll();
    }));
  }

  function draw(fit, found, study, muscle) {
    const best = Object.assign({}, muscle), days = study.measurements.map((m) => m.time);
    found.parameters.forEach((p) => { best[p.name] = p.estimate; });
    const run = page.law.pull(best, cut(study.knots, days, 0.002, 0.03)), measured = new Array(run.time.length).fill(null);
    for (const m of study.measurements) {
      let i = run.time.length - 1;
      while (i > 0 && run.time[i] > m.time + 1e-9) --i;
      measured[i] = m.quantity === "G" ? run.stretch[i] / m.value : m.value;
    }
    chart.element.hidden = false;
    chart.set(run.time, [run.lambda_e, measured]);
  }

  data.addEventListener("input", () => {
    page.model.fit.data = data.value;
    fault.textContent = "";
    page.keep();
  });
  const example = () => {
    page.model.fit.data = EXAMPLE;
    show();
    page.keep();
    compute();
  };
  const element = h("section", {"aria-label": F.heading}, h("h2", {}, F.heading), h("label", {for: dataId}, F.data),
    h("p", {class: "note"}, F.hint), data, fault, rest.element, h("p", {class: "note"}, F.history),
    table(F.bounds, [S.uncertainty.parameter, S.uncertainty.from, S.uncertainty.to], boundRows),
    h("div", {class: "row"}, button(F.run, compute, {id: "fit_run"}), button(F.example, example)), result, chart.element);
  return {element, update: () => {}, show};
}
