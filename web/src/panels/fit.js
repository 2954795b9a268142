// Fit: tau and lambda_crit from measured sarcomere lengths, with intervals.
import {Chart} from "../chart.js";
import {button, h, newId, table} from "../dom.js";
import {Fit, boundsOf} from "../fit.js";
import {cut, rampAndHold} from "../history.js";
import {FITTED, rangeFault} from "../model.js";
import {muscleOf} from "../programme.js";
import {S} from "../strings.js";
import {readPlain, readText} from "../study.js";
import {faultOf, hint, textOf, toNumber} from "../text.js";
import {EXAMPLE} from "./fit_example.js";
import {modelField} from "./play.js";

const F = S.fit, U = S.uncertainty;
const KEYWORDS = /^\ufeff?\s*(title|include|set|fit|rest_length|step|ramp|hold|distract|cycle|tendon|measure)\s*(,|$)/m;

/** The rows as a study. Rows without keywords are day, value, sd; they get the history of the tab Play. */
function studyOf(page, text) {
  const {rest} = page.model.fit, study = KEYWORDS.test(text) ? readText(F.file, text) : readPlain(F.file, text);
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
  let used = "";
  chart.element.hidden = true;
  const boundRows = FITTED.map((name) => {
    bounds[name] = [U.low, U.high].map((label, k) => h("input", {type: "text", inputmode: "decimal", name: `fit_${name}_${k}`,
      autocomplete: "off", "aria-label": label(S.muscle.symbols[name]), "aria-describedby": faultId, oninput: () => takeBounds()}));
    return [S.muscle.symbols[name], ...bounds[name]];
  });

  /** What the measurements are computed with, besides the parameters that are found. */
  function inputs() {
    const {muscle, fit, play} = page.model;
    return JSON.stringify([Object.assign({}, muscle, {tau: 0, lambda_crit: 0}), fit, play]);
  }

  /** Results of other inputs are not shown. */
  function update() {
    if (inputs() === used) return;
    result.replaceChildren();
    chart.element.hidden = true;
  }

  function takeBounds() {
    const given = {}, boxes = FITTED.reduce((all, name) => all.concat(bounds[name]), []);
    const say = (text, box) => {
      fault.textContent = text;
      boxes.forEach((one) => one.setAttribute("aria-invalid", String(one === box)));
      return text === "";
    };
    for (const box of boxes) {
      const text = box.value.trim();
      if (Number.isNaN(toNumber(text))) return say(S.expected(box.getAttribute("aria-label"), S.anyNumber, text, hint(text)), box);
    }
    for (const name of FITTED) given[name] = bounds[name].map((box) => toNumber(box.value.trim()));
    const wrong = rangeFault(page.law, page.model.muscle, given);
    if (wrong) {
      const box = bounds[wrong.name][wrong.end];
      return say(`${box.getAttribute("aria-label")}: ${wrong.text}`, box);
    }
    const equal = FITTED.find((name) => given[name][0] === given[name][1]);
    if (equal) return say(F.order(S.muscle.symbols[equal], ...given[equal]), bounds[equal][0]);
    Object.assign(page.model.fit, given);
    page.keep();
    update();
    return say("");
  }

  function show() {
    rest.show();
    if (data.value !== page.model.fit.data) data.value = page.model.fit.data;
    for (const name of FITTED) bounds[name].forEach((box, k) => { box.value = String(page.model.fit[name][k]); });
  }

  function compute() {
    result.replaceChildren();
    chart.element.hidden = true;
    if (!takeBounds()) return;
    fault.textContent = faultOf(() => {
      const study = studyOf(page, data.value), muscle = muscleOf(page.law, study, page.model.muscle);
      const ranges = boundsOf(page.law, study, muscle, page.model.fit);
      const found = new Fit(page.law, muscle, study.knots, study.measurements, ranges).best(FITTED.map((name) => muscle[name]));
      page.fitted = found;
      used = inputs();
      report(found, ranges, study);
      draw(found, study, muscle);
    });
  }

  function report(found, ranges, study) {
    const shown = (x) => isFinite(x) ? x.toPrecision(5) : F.open;
    const notes = [];
    for (const p of found.parameters) {
      if (p.atBound) notes.push(F.atBound(S.muscle.symbols[p.name]));
      if (!isFinite(p.lower) || !isFinite(p.upper)) notes.push(F.unbounded(S.muscle.symbols[p.name]));
    }
    const freedom = found.n - 2, end = study.knots[study.knots.length - 1].time;
    const last = study.measurements.reduce((most, m) => Math.max(most, m.time), 0);
    if (last > end) notes.push(F.beyond(end, last));
    if (found.n < 3) notes.push(F.few);
    if (found.agreeing === 1) notes.push(F.one);
    if (freedom > 0 && found.chi2 > freedom + 3 * Math.sqrt(2 * freedom)) notes.push(F.misses(found.chi2, freedom));
    result.replaceChildren(table(F.heading, F.columns, found.parameters.map((p) => [S.muscle.symbols[p.name], shown(p.estimate),
      shown(p.sd), F.interval(shown(p.low), shown(p.high)), F.interval(shown(p.lower), shown(p.upper)),
      F.interval(...ranges[p.name].map(textOf))])), h("p", {}, F.sum(found.n, found.chi2, found.agreeing, found.starts)),
    ...notes.map((text) => h("p", {class: "warning"}, text)), button(F.use, () => {
      for (const p of found.parameters) page.model.muscle[p.name] = Number(p.estimate.toPrecision(6));
      page.changed();
      page.showAll();
    }));
  }

  function draw(found, study, muscle) {
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
    update();
  });
  const example = () => {
    page.model.fit.data = EXAMPLE;
    show();
    page.keep();
    compute();
  };
  const element = h("section", {"aria-label": F.heading}, h("h2", {}, F.heading), h("label", {for: dataId}, F.data),
    h("p", {class: "note"}, F.hint), data, fault, rest.element, h("p", {class: "note"}, F.history),
    table(F.bounds, [U.parameter, U.from, U.to], boundRows),
    h("div", {class: "row"}, button(F.run, compute, {id: "fit_run"}), button(F.example, example)), result, chart.element);
  return {element, update, show};
}
