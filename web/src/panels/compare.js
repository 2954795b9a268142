// Compare: up to four programmes, edited row by row or read from CSV files; a table, curves, and files of them.
import {Chart, savePng, saveSvg} from "../chart.js";
import {button, h, newId, saveText, table} from "../dom.js";
import {cut, valueAt} from "../history.js";
import {judge} from "../judge.js";
import {InputError} from "../rows.js";
import {csvOf, muscleOf, readStudy, readText} from "../study.js";
import {S} from "../strings.js";
import {modelField} from "./play.js";

const MOST = 4, NAMES = ["stretch", "lambda_e", "G", "force"], C = S.compare;
const STARTS = {step: "step, 1.05", ramp: "ramp, 1.1, 7", hold: "hold, 7", distract: "distract, 1, 7",
  cycle: "cycle, 1.05, 8, 1, 14", repeat: "repeat, 2, 3"};

/** A programme's text as lines {kind, fields}, for the editor; others, like set, are kept as they are. */
function linesOf(text) {
  return text.split("\n").filter((line) => line.split("#")[0].trim()).map((line) => {
    const fields = line.split("#")[0].split(",").map((f) => f.trim());
    return {kind: fields[0], fields: fields.slice(1)};
  });
}
const textOfLines = (lines) => lines.map((l) => [l.kind, ...l.fields].join(", ")).join("\n") + "\n";

class Programme {
  constructor(panel, at) {
    Object.assign(this, {panel, at, faults: [], general: h("p", {class: "fault", role: "alert"})});
    this.element = h("fieldset", {class: `programme p${at}`});
    this.build();
  }

  get lines() { return linesOf(this.panel.page.model.programmes[this.at]); }
  set lines(lines) {
    this.panel.page.model.programmes[this.at] = textOfLines(lines);
    this.panel.page.changed();
  }

  /** A line of one text, title or rest_length, which may be missing. */
  single(kind, label, attributes) {
    const id = newId(), found = this.lines.findIndex((l) => l.kind === kind), fault = h("p", {class: "fault", role: "alert",
      id: newId()});
    const input = h("input", Object.assign({id, type: "text", "aria-describedby": fault.id, autocomplete: "off",
      value: found < 0 ? "" : this.lines[found].fields.join(", ")}, attributes));
    input.addEventListener("input", () => {
      const lines = this.lines.filter((l) => l.kind !== kind), value = input.value.trim();
      this.lines = value ? [{kind, fields: [value]}].concat(lines) : lines;
    });
    this.slots.push({is: (l) => l.kind === kind, fault});
    return h("div", {class: "field"}, h("label", {for: id}, label), input, fault);
  }

  row(index, n) {
    const line = this.lines[index], fault = h("p", {class: "fault", role: "alert", id: newId()});
    const kind = h("select", {"aria-label": `${C.row(n)}: ${C.kind}`},
      ...Object.keys(C.kinds).map((k) => h("option", {value: k, selected: k === line.kind}, C.kinds[k])));
    kind.addEventListener("change", () => {
      const lines = this.lines;
      lines[index] = linesOf(STARTS[kind.value])[0];
      if (kind.value === "distract" && !lines.some((l) => l.kind === "rest_length"))
        lines.unshift({kind: "rest_length", fields: ["100"]});
      this.lines = lines;
      this.build();
      this.element.querySelectorAll(".row select")[n - 1].focus();
    });
    const inputs = C.fields[line.kind].map((label, i) => {
      const input = h("input", {type: "text", inputmode: "decimal", value: line.fields[i] || "", autocomplete: "off",
        "aria-label": `${C.row(n)}: ${label}`, "aria-describedby": fault.id});
      input.addEventListener("input", () => {
        const lines = this.lines;
        lines[index].fields[i] = input.value.trim();
        this.lines = lines;
      });
      return h("span", {class: "pair"}, h("span", {"aria-hidden": "true"}, label), input);
    });
    const remove = button("×", () => {
      this.lines = this.lines.filter((l, i) => i !== index);
      this.build();
    }, {"aria-label": C.removeRow(n), class: "small"});
    this.slots.push({is: (l, i) => i === index, fault});
    return h("div", {class: "row"}, kind, ...inputs, remove, fault);
  }

  build() {
    this.slots = [];
    const lines = this.lines, rows = [];
    const title = this.single("title", C.programmeTitle), rest = this.single("rest_length", C.rest, {inputmode: "decimal"});
    lines.forEach((line, i) => { if (C.kinds[line.kind]) rows.push(this.row(i, rows.length + 1)); });
    const own = lines.filter((l) => l.kind === "set");
    const ownText = own.map((l) => `${l.fields[0]} = ${l.fields[1]}`).join(", ");
    this.element.replaceChildren(h("legend", {}, C.programme(this.at + 1)), title, rest, ...rows, this.general,
      h("div", {class: "row"}, button(C.addRow, () => {
        this.lines = this.lines.concat(linesOf(STARTS.hold));
        this.build();
      }), button(C.remove, () => this.panel.remove(this.at), {"aria-label": `${C.remove} ${this.at + 1}`})),
      own.length > 0 ? h("p", {class: "note"}, C.own(ownText), " ", button(C.useMine, () => {
        this.lines = this.lines.filter((l) => l.kind !== "set");
        this.build();
      })) : "");
  }

  /** The study, or null, with the fault shown where it stands. */
  read() {
    this.general.textContent = "";
    for (const slot of this.slots) slot.fault.textContent = "";
    const name = C.programme(this.at + 1);
    try {
      const study = readText(name, this.panel.page.model.programmes[this.at], true);
      if (study.knots.length < 2) throw new InputError(`${name}: ${C.noRows}`);
      study.muscle = muscleOf(this.panel.page.law, study, this.panel.page.model.muscle);
      return study;
    } catch (e) {
      if (!(e instanceof InputError)) throw e;
      const line = e.row === undefined ? null : this.lines[e.row];
      const slot = line && this.slots.find((s) => s.is(line, e.row));
      (slot ? slot.fault : this.general).textContent = slot ? e.words : e.message;
      return null;
    }
  }
}

export function comparePanel(page) {
  const fields = [modelField(page, "limit", C.limit, "–"), modelField(page, "within", C.within, "–")];
  const charts = NAMES.map((name) => new Chart({title: S.curves[name], sync: "compare", series: []}));
  const place = h("div", {class: "programmes"}), result = h("div", {id: "comparison", "aria-live": "polite"});
  const message = h("p", {class: "fault", role: "alert", id: "compare_message"});
  const fileId = newId(), file = h("input", {type: "file", id: fileId, accept: ".csv,text/csv,text/plain", multiple: true});
  let programmes = [], runs = [];
  const panel = {page, remove: (at) => {
    page.model.programmes.splice(at, 1);
    show();
    page.changed();
  }};

  function show() {
    fields.forEach((f) => f.show());
    page.model.programmes = page.model.programmes.map((text) => textOfLines(linesOf(text)));
    programmes = page.model.programmes.map((text, i) => new Programme(panel, i));
    place.replaceChildren(...programmes.map((p) => p.element));
  }

  function addText(text) {
    if (page.model.programmes.length >= MOST) {
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
    const bytes = new Map(), faults = [];
    for (const f of files) {
      let text = "";
      for (const b of new Uint8Array(await f.arrayBuffer())) text += String.fromCharCode(b);
      bytes.set(f.name, text);
    }
    const included = new Set();
    for (const text of bytes.values()) {
      for (const found of text.matchAll(/^\s*include\s*,\s*([^#\r\n]*)/gm)) included.add(found[1].trim().split("/").pop());
    }
    for (const name of bytes.keys()) {
      if (included.has(name)) continue;
      try {
        const study = readStudy(bytes, name, true);
        if (study.knots.length < 2) throw new InputError(`${name}: ${C.noRows}`);
        muscleOf(page.law, study, page.model.muscle);
        const text = csvOf(study);
        const same = page.model.programmes.findIndex((p) => readTitle(p) === study.title);
        if (same >= 0) {
          page.model.programmes[same] = text;
          faults.push(C.sameName(study.title));
        } else if (page.model.programmes.length >= MOST) {
          faults.push(`${name}: ${C.full}`);
        } else {
          page.model.programmes.push(text);
        }
      } catch (e) {
        faults.push(e.message);
      }
    }
    show();
    page.changed();
    message.textContent = faults.join(" ");
  }
  const readTitle = (text) => (linesOf(text).find((l) => l.kind === "title") || {fields: [""]}).fields.join(", ");

  function update() {
    const {limit, within} = page.model.compare, studies = programmes.map((p) => p.read());
    const good = studies.filter((s) => s);
    const end = Math.max(0, ...good.map((s) => s.knots[s.knots.length - 1].time));
    runs = [];
    good.forEach((study) => {
      try {
        const at = programmes[studies.indexOf(study)].at;
        runs.push({study, at, run: page.law.pull(study.muscle, cut(study.knots, [end], 0.002, 0.02))});
      } catch (e) {
        programmes[studies.indexOf(study)].general.textContent = e.message;
      }
    });
    const day = (x) => isFinite(x) ? x > 0 ? x.toFixed(2) : C.always : C.never;
    result.replaceChildren(table(S.compare.heading, C.columns, runs.map(({study, run}) => {
      const o = judge(run, limit, within);
      return [study.title, o.lengthened.toFixed(2), o.peak.toFixed(4), o.peakDay.toFixed(2), o.above.toFixed(3),
        o.dose.toFixed(5), day(o.returned), o.peakForce.toFixed(4), o.G.toFixed(4)];
    })));
    if (runs.length === 0) return;
    const time = Array.from(new Set(runs.reduce((all, {run}) => all.concat(Array.from(run.time)), []))).sort((a, b) => a - b);
    const twice = new Set();
    for (const {run} of runs) for (let i = 1; i < run.time.length; ++i) if (run.time[i] === run.time[i - 1]) twice.add(run.time[i]);
    const both = time.reduce((all, t) => all.concat(twice.has(t) ? [t, t] : [t]), []);
    charts.forEach((chart, k) => {
      const columns = runs.map(({run}) => both.map((t, i) => both[i + 1] === t ? before(run, NAMES[k], t)
        : valueAt(run.time, run[NAMES[k]], t)));
      const lines = NAMES[k] === "lambda_e" ? [{value: limit, label: C.limitLine},
        {value: 1 + within, label: C.returnLine}] : [];
      chart.set(both, columns, lines, runs.map(({study, at}) => ({label: study.title, colour: at})));
    });
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
      button(C.programmes, () => runs.forEach(({study, at}) => saveText(`programme${at + 1}.csv`, csvOf(study)))),
      button(C.png, () => savePng("programmes.png", charts)), button(C.svg, () => saveSvg("programmes.svg", charts))));
  return {element, update, show, open};
}

/** The value just before a step at time t. */
function before(run, name, t) {
  const i = run.time.indexOf(t);
  return i < 0 ? valueAt(run.time, run[name], t) : run[name][i];
}

