// Design: the fastest admissible programme to a stretch, with its schedule day by day, to be printed.
import {Chart} from "../chart.js";
import {button, h, saveText, table} from "../dom.js";
import {design} from "../design.js";
import {valueAt} from "../history.js";
import {S} from "../strings.js";
import {modelField} from "./play.js";

const D = S.design;

export function designPanel(page) {
  const fields = [modelField(page, "target", D.target, "–", [1.01, 1.5, 0.005]),
    modelField(page, "design_limit", D.limit, "–", [1.01, 1.3, 0.005]), modelField(page, "rest", D.rest, D.mm)];
  const lines = Object.values(D.lines).map((label, i) => ({label, colour: i}));
  const charts = ["stretch", "lambda_e"].map((name) => new Chart({title: S.curves[name], sync: "design", series: lines}));
  const message = h("p", {class: "fault", role: "alert", id: "design_message"});
  const result = h("div", {id: "plan", class: "result", "aria-live": "polite"});
  const schedule = h("div", {id: "schedule", class: "result"});
  let plan = null, waiting = 0;

  function show() {
    fields.forEach((f) => f.show());
  }

  function compute() {
    plan = design(page.law, page.model.muscle, page.model.design);
    message.textContent = plan.impossible || "";
    actions.hidden = Boolean(plan.impossible);
    if (plan.impossible) {
      result.replaceChildren();
      schedule.replaceChildren();
      charts.forEach((c) => { c.element.hidden = true; });
      return;
    }
    const {target, limit, rest} = page.model.design;
    result.replaceChildren(h("p", {}, D.result(rest * (target - 1), rest)), table(D.heading, D.rows, [
      [D.fastest, plan.days.toFixed(4), Math.min(limit, target).toFixed(4)],
      [D.daily, isFinite(plan.stepDays) ? String(plan.stepDays) : D.notArrive, plan.stepPeak.toFixed(4)],
      [D.ramp, isFinite(plan.rampDays) ? plan.rampDays.toFixed(4) : D.tooSlow, Math.min(limit, target).toFixed(4)],
    ]));
    schedule.replaceChildren(table(D.schedule, D.columns, plan.schedule.map((row) => [String(row.day), row.stretch.toFixed(4),
      row.mm.toFixed(2), row.today.toFixed(2), row.stepStretch.toFixed(4), row.stepMm.toFixed(2), row.stepToday.toFixed(2)])));
    const last = 1.35 * Math.max(plan.days, plan.stepDays || 0, 1);
    charts.forEach((chart, k) => {
      const name = ["stretch", "lambda_e"][k];
      chart.element.hidden = false;
      const time = Array.from(plan.run.time).filter((t) => t <= last), steps = Array.from(plan.steps.time).filter((t) => t <= last);
      const all = Array.from(new Set(time.concat(steps))).sort((a, b) => a - b);
      chart.set(all, [plan.run, plan.steps].map((run) => all.map((t) => valueAt(run.time, run[name], t))),
        [{value: k === 0 ? target : limit, label: k === 0 ? D.target : D.limit}]);
    });
  }

  const actions = h("div", {class: "row"}, button(D.print, () => print()),
    button(D.csv, () => saveText("schedule.csv", "day,fastest_stretch,fastest_mm,fastest_mm_this_day,steps_stretch,steps_mm," +
      "steps_mm_this_day\n" + plan.schedule.map((row) => Object.values(row).join(",")).join("\n") + "\n")));
  const element = h("section", {"aria-label": D.heading}, h("h2", {}, D.heading),
    h("div", {class: "fields"}, ...fields.map((f) => f.element)), message, result,
    h("div", {class: "charts"}, ...charts.map((c) => c.element)), actions, schedule);
  // A plan takes a tenth of a second: not for every pixel of a slider.
  const update = () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => page.attempt("design", compute), 60);
  };
  return {element, update, show};
}
