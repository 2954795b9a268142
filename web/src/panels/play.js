// Play: one stretch, its curves, the exact solution's numbers, and the picture of sarcomeres.
import {Bands, coarse} from "../bands.js";
import {Chart} from "../chart.js";
import {button, field, h, newId} from "../dom.js";
import {cut, rampAndHold, valueAt} from "../history.js";
import {exact} from "../judge.js";
import {ALLOWED, rangeFault, rangesOf} from "../model.js";
import {Sarcomeres} from "../sarcomeres.js";
import {S} from "../strings.js";
import {faultOf} from "../text.js";

const SLIDERS = {stretch: [0.8, 1.5, 0.005], ramp: [0, 28, 0.25], hold: [0, 365, 1], days: [1, 365, 1]};
const LEVELS = [0.05, 0.03, 0.02], HISTORIES = 200, DELAY = 120;

/** A number field of the model that ALLOWED knows. */
export function modelField(page, key, label, unit, slider) {
  const [group, name, least, most] = ALLOWED[key];
  return field({key, label, unit, least, most, slider, get: () => page.model[group][name], set: (x) => {
    page.model[group][name] = x;
    page.changed();
  }});
}

export function playPanel(page) {
  const fields = Object.keys(SLIDERS).map((key) => modelField(page, key, S.play[key],
    key === "stretch" ? S.play.stretchUnit : S.play.daysUnit, SLIDERS[key]));
  const charts = ["lambda_e", "G", "force"].map((name, i) => new Chart({title: S.curves[name], sync: "play", bands: [[2, 1]],
    series: [{label: S.curves.short[name], colour: i, dash: false},
      {label: S.curves.low, colour: i, dash: false, hidden: true},
      {label: S.curves.high, colour: i, dash: false, hidden: true}]}));
  const numbers = h("dl", {class: "numbers", id: "numbers", "aria-live": "polite"});
  const picture = new Sarcomeres(), bandsId = newId(), dayId = newId();
  const withBands = h("input", {type: "checkbox", id: bandsId, checked: true});
  const day = h("input", {type: "range", id: dayId, name: "day", min: 0, max: 1000, value: 1000});
  const bandFault = h("p", {class: "fault", role: "alert", id: "band_fault"});
  const readout = h("p", {class: "readout", id: "readout"});
  const animate = button(S.play.animate, () => timer ? stop() : start());
  let run = null, bands = null, waiting = 0, timer = 0;

  function look() {
    if (!run) return;
    const at = Math.pow(Number(day.value) / 1000, 2) * run.time[run.time.length - 1];
    const [lambda, G, force] = ["stretch", "G", "force"].map((name) => valueAt(run.time, run[name], at));
    const text = S.play.at(at, lambda, lambda / G, G, force);
    readout.textContent = text;
    day.setAttribute("aria-valuetext", text);
    picture.show(lambda, G, run.stretch.reduce((a, b) => Math.max(a, b), 0));
  }
  function stop() {
    clearInterval(timer);
    timer = 0;
    animate.textContent = S.play.animate;
  }
  function start() {
    day.value = 0;
    animate.textContent = S.play.stop;
    timer = setInterval(() => {
      day.value = Number(day.value) + 8;
      look();
      if (Number(day.value) >= 1000) stop();
    }, 40);
  }

  function draw() {
    charts.forEach((chart, i) => {
      const name = ["lambda_e", "G", "force"][i], none = new Array(run.time.length).fill(null);
      const [low, high] = bands ? bands[name].map((b) => run.time.map((t) => valueAt(bands.time, b, t))) : [none, none];
      chart.set(run.time, [run[name], low, high]);
    });
  }

  function update() {
    const {law, model} = page, started = performance.now(), knots = rampAndHold(model.play);
    run = law.pull(model.muscle, cut(knots, [], 0.005, 0.03));
    bands = null;
    bandFault.textContent = "";
    draw();
    const e = exact(law, model.muscle, knots, LEVELS.map((x) => 1 + x));
    const day0 = (x) => x === 0 ? S.play.always : isFinite(x) ? x.toFixed(3) : S.play.never;
    const entries = [["peak", S.play.peak, e.peak.toFixed(5)], ["peakDay", S.play.peakDay, e.peakDay.toFixed(2)],
      ...LEVELS.map((level, i) => [`returned${100 * level}`, S.play.returned(100 * level), day0(e.returned[i])]),
      ["finalLambda", S.play.finalLambda, e.lambda_e.toFixed(5)], ["finalG", S.play.finalG, e.G.toFixed(5)]];
    numbers.replaceChildren(...entries.map(([id, name, value]) =>
      h("div", {}, h("dt", {}, name), h("dd", {id: `n_${id}`}, value))));
    look();
    page.milliseconds = performance.now() - started;
    clearTimeout(waiting);
    if (withBands.checked) waiting = setTimeout(drawBands, DELAY, knots);
  }

  function drawBands(knots) {
    const {law, model} = page, ranges = rangesOf(model), points = coarse(knots);
    const many = new Bands(law, model.muscle, ranges, points), wrong = rangeFault(law, model.muscle, ranges);
    const why = wrong ? wrong.text : faultOf(() => many.add(HISTORIES));
    bandFault.textContent = why && S.play.noBand(why);
    if (why) return;
    bands = {time: points.time};
    for (const name of ["lambda_e", "G", "force"]) bands[name] = many.percentiles(name, [0.05, 0.95]);
    draw();
  }

  withBands.addEventListener("change", update);
  day.addEventListener("input", look);
  const element = h("section", {"aria-label": S.play.heading}, h("h2", {}, S.play.heading),
    h("div", {class: "fields"}, ...fields.map((f) => f.element)),
    h("h3", {}, S.play.picture), picture.element,
    h("div", {class: "row"}, h("label", {for: dayId}, S.play.day), day, animate), readout,
    h("h3", {}, S.play.numbers), numbers,
    h("div", {class: "row"}, withBands, h("label", {for: bandsId}, S.play.bands)), bandFault,
    h("div", {class: "charts"}, ...charts.map((c) => c.element)));
  return {element, update, show: () => fields.forEach((f) => f.show()), hide: stop};
}
