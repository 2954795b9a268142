// Compare: up to four programmes, edited row by row or read from CSV files; a table, curves, and files of them.
import {Chart} from "../chart.js";
import {button, h, newId, saveText, table} from "../dom.js";
import {along, cut, timesOf} from "../history.js";
import {judge} from "../judge.js";
import {MOST_PROGRAMMES} from "../model.js";
import {savePng, saveSvg} from "../picture.js";
import {csvOf, muscleOf} from "../programme.js";
import {Rows} from "../rows.js";
import {includedBy, readStudy} from "../study.js";
import {S} from "../strings.js";
import {InputError, bytesOf, faultOf} from "../text.js";
import {Editor, STARTS, linesOf, textOfLines} from "./editor.js";
import {modelField} from "./play.js";

const NAMES = ["stretch", "lambda_e", "G", "force"], C = S.compare, MOST_BYTES = 1e7;

export function comparePanel(page) {
  const fields = [modelField(page, "limit", C.limit, "–"), modelField(page, "within", C.within, "–")];
  const charts = NAMES.map((name) => new Chart({title: S.curves[name], sync: "compare", series: []}));
  const place = h("div", {class: "programmes"}), result = h("div", {id: "comparison", class: "result", "aria-live": "polite"});
  const message = h("p", {class: "fault", role: "alert", id: "compare_message"});
  const fileId = newId(), file = h("input", {type: "file", id: fileId, accept: ".csv,text/csv,text/plain", multiple: true});
  let programmes = [], runs = [];
  const remove = (at) => {
    page.model.programmes.splice(at, 1);
    message.textContent = "";
    show();
    page.changed();
  };

  function show() {
    fields.forEach((f) => f.show());
    page.model.programmes = page.model.programmes.map((text) => textOfLines(linesOf(text)));
    programmes = page.model.programmes.map((text, i) => new Editor(page, i, remove));
    place.replaceChildren(...programmes.map((p) => p.element));
  }

  function addText(text) {
    if (page.model.programmes.length >= MOST_PROGRAMMES) {
      message.textContent = C.full;
      return;
    }
    page.model.programmes.push(text);
    show();
    page.changed();
  }

  /** Files that were dropped or opened; those that others include are read with them. */
  async function open(files) {
    message.textContent = "";
    const bytes = new Map(), said = [], included = new Set(), titles = new Set();
    for (const f of files) {
      try {
        if (f.size > MOST_BYTES) throw new InputError(C.tooLarge(MOST_BYTES / 1e6));
        bytes.set(f.name, bytesOf(await f.arrayBuffer()));
      } catch (e) {
        said.push(`${f.name}: ${e instanceof InputError ? e.message : C.unreadable}`);
      }
    }
    for (const [name, text] of bytes) {
      faultOf(() => { // readStudy says what is wrong
        const rows = new Rows(name, text);
        while (rows.next()) included.add(includedBy(rows));
      });
    }
    const names = Array.from(bytes.keys()), first = names.filter((name) => !included.has(name));
    for (const name of first.length > 0 ? first : names) {
      said.push(faultOf(() => {
        const study = readStudy(bytes, name, true);
        if (study.knots.length < 2) throw new InputError(`${name}: ${C.noRows}`);
        muscleOf(page.law, study, page.model.muscle);
        if (titles.has(study.title)) study.title = `${study.title}, ${study.otherTitle}`;
        titles.add(study.title);
        const text = csvOf(study), same = page.model.programmes.findIndex((p) => readTitle(p) === readTitle(text));
        if (same < 0 && page.model.programmes.length >= MOST_PROGRAMMES) throw new InputError(`${name}: ${C.full}`);
        if (same >= 0) said.push(C.sameName(study.title));
        page.model.programmes[same >= 0 ? same : page.model.programmes.length] = text;
      }));
    }
    show();
    page.changed();
    message.textContent = said.filter((text) => text).join(" ");
  }
  const readTitle = (text) => (linesOf(text).find((l) => l.kind === "title") || {fields: [""]}).fields.join(", ");

  function update() {
    const {limit, within} = page.model.compare, studies = programmes.map((p) => p.read());
    const good = studies.filter((s) => s);
    const end = Math.max(0, ...good.map((s) => s.knots[s.knots.length - 1].time));
    runs = [];
    programmes.forEach((programme, at) => {
      const study = studies[at];
      if (study) programme.say(faultOf(() => {
        runs.push({study, at, run: page.law.pull(study.muscle, cut(study.knots, [end], 0.002, 0.02))});
      }));
    });
    const day = (x) => isFinite(x) ? x > 0 ? x.toFixed(2) : C.always : C.never;
    result.replaceChildren(table(S.compare.heading, C.columns, runs.map(({study, run}) => {
      const o = judge(run, limit, within);
      return [study.title, o.lengthened.toFixed(2), o.peak.toFixed(4), o.peakDay.toFixed(2), o.above.toFixed(3),
        o.dose.toFixed(5), day(o.returned), o.peakForce.toFixed(4), o.G.toFixed(4)];
    })));
    if (runs.length === 0) return;
    const times = timesOf(runs.map(({run}) => run.time));
    charts.forEach((chart, k) => {
      const columns = runs.map(({run}) => along(times, run.time, run[NAMES[k]]));
      const lines = NAMES[k] === "lambda_e" ? [{value: limit, label: C.limitLine},
        {value: 1 + within, label: C.returnLine}] : [];
      chart.set(times, columns, lines, runs.map(({study, at}) => ({label: study.title, colour: at})));
    });
  }

  /** The parameters, for pictures. */
  function notes() {
    const own = runs.filter(({study}) => Object.keys(study.set).length > 0);
    return [page.printed.textContent].concat(own.map(({study}) => C.ownOf(study.title, Object.entries(study.set)
      .map(([name, x]) => `${S.muscle.symbols[name]} = ${x}`).join(", "))));
  }

  function saveCurves() {
    const rows = ["programme,day,stretch,G,lambda_e,force_per_reference_area,lateral_stretch"];
    for (const {study, run} of runs) {
      const title = `"${study.title.replace(/"/g, '""')}"`;
      for (let i = 0; i < run.time.length; ++i)
        rows.push([title, ...["time", "stretch", "G", "lambda_e", "force", "lateral"].map((n) => run[n][i])].join(","));
    }
    saveText("curves.csv", rows.join("\n") + "\n");
  }

  file.addEventListener("change", () => open(file.files).then(() => { file.value = ""; }));
  const element = h("section", {"aria-label": C.heading}, h("h2", {}, C.heading), place,
    h("div", {class: "row"}, button(C.add, () => addText(`title, ${C.programme(page.model.programmes.length + 1)}\n` +
      `${STARTS.ramp}\nhold, 35\n`)), h("label", {for: fileId}, C.open), file), h("p", {class: "note"}, C.drop), message,
    h("div", {class: "fields"}, ...fields.map((f) => f.element)), result,
    h("div", {class: "charts"}, ...charts.map((c) => c.element)),
    h("div", {class: "row"}, button(C.csv, saveCurves),
      button(C.programmes, () => runs.forEach(({study, at}) => saveText(`programme${at + 1}.csv`, csvOf(study, study.muscle)))),
      button(C.png, () => savePng("programmes.png", charts, notes())),
      button(C.svg, () => saveSvg("programmes.svg", charts, notes()))));
  return {element, update, show, open};
}
