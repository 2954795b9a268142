// The editor of one programme: its title, the length at rest, and its rows.
import {button, h, newId} from "../dom.js";
import {muscleOf} from "../programme.js";
import {readText} from "../study.js";
import {S} from "../strings.js";
import {InputError, hint} from "../text.js";

const C = S.compare;
export const STARTS = {step: "step, 1.05", ramp: "ramp, 1.1, 7", hold: "hold, 7", distract: "distract, 1, 7",
  cycle: "cycle, 1.05, 8, 1, 14", repeat: "repeat, 2, 3"};

/** A programme's text as lines {kind, fields}; all of them stay, also those that the editor has no fields for, like set. */
export function linesOf(text) {
  return text.split(/\r\n|\r|\n/).map((line) => line.split("#")[0]).filter((line) => line.trim()).map((line) => {
    const [kind, ...fields] = line.split(",").map((f) => f.trim());
    return {kind, fields};
  });
}
export const textOfLines = (lines) => lines.map((l) => [l.kind, ...l.fields].join(", ")).join("\n") + "\n";

export class Editor {
  constructor(page, at, remove) {
    Object.assign(this, {page, at, remove, lines: linesOf(page.model.programmes[at])});
    this.general = h("p", {class: "fault", role: "alert"});
    this.element = h("fieldset", {class: `programme p${at}`});
    this.build();
  }

  changed() {
    this.page.model.programmes[this.at] = textOfLines(this.lines);
    this.page.changed();
  }

  /** Other rows, with fields of their own. */
  rebuild(lines) {
    this.lines = lines;
    this.build();
    this.changed();
  }

  slot(has, inputs) {
    const fault = h("p", {class: "fault", role: "alert", id: newId()});
    inputs.forEach((input) => input.setAttribute("aria-describedby", fault.id));
    this.slots.push({has, inputs, fault});
    return fault;
  }

  /** A line of one text, title or rest_length, which may be missing. */
  single(kind, label, attributes) {
    const id = newId(), found = () => this.lines.find((l) => l.kind === kind);
    const input = h("input", Object.assign({id, type: "text", autocomplete: "off",
      value: found() ? found().fields.join(", ") : ""}, attributes));
    input.addEventListener("input", () => {
      const line = found(), fields = [input.value.trim()];
      if (!fields[0]) this.lines = this.lines.filter((l) => l !== line);
      else if (line) line.fields = fields;
      else this.lines.unshift({kind, fields});
      this.changed();
    });
    return h("div", {class: "field"}, h("label", {for: id}, label), input, this.slot((l) => l.kind === kind, [input]));
  }

  row(line, n) {
    const kind = h("select", {"aria-label": `${C.row(n)}: ${C.kind}`},
      ...Object.keys(C.kinds).map((k) => h("option", {value: k, selected: k === line.kind}, C.kinds[k])));
    kind.addEventListener("change", () => {
      const lines = this.lines.map((l) => l === line ? linesOf(STARTS[kind.value])[0] : l);
      if (kind.value === "distract" && !lines.some((l) => l.kind === "rest_length"))
        lines.unshift({kind: "rest_length", fields: ["100"]});
      this.rebuild(lines);
      this.element.querySelectorAll(".row select")[n - 1].focus();
    });
    const inputs = C.fields[line.kind].map((label, i) => h("input", {type: "text", inputmode: "decimal",
      value: line.fields[i] || "", autocomplete: "off", "aria-label": `${C.row(n)}: ${label}`}));
    for (const input of inputs) {
      input.addEventListener("input", () => {
        line.fields = inputs.map((one) => one.value.trim());
        this.changed();
      });
    }
    const remove = button("×", () => this.rebuild(this.lines.filter((l) => l !== line)),
      {"aria-label": C.removeRow(n), class: "small"});
    return h("div", {class: "row"}, kind, ...inputs.map((input, i) => h("span", {class: "pair"},
      h("span", {"aria-hidden": "true"}, C.fields[line.kind][i]), input)), remove, this.slot((l) => l === line, inputs));
  }

  build() {
    this.slots = [];
    const title = this.single("title", C.programmeTitle), rest = this.single("rest_length", C.rest, {inputmode: "decimal"});
    const rows = this.lines.filter((l) => Object.keys(C.kinds).includes(l.kind)).map((l, i) => this.row(l, i + 1));
    const own = this.lines.filter((l) => l.kind === "set");
    this.element.replaceChildren(h("legend", {}, C.programme(this.at + 1)), title, rest, ...rows, this.general,
      h("div", {class: "row"}, button(C.addRow, () => this.rebuild(this.lines.concat(linesOf(STARTS.hold)))),
        button(C.remove, () => this.remove(this.at), {"aria-label": `${C.remove} ${this.at + 1}`})),
      own.length === 0 ? "" : h("p", {class: "note"}, C.own(own.map((l) => l.fields.join(" = ")).join(", ")), " ",
        button(C.useMine, () => this.rebuild(this.lines.filter((l) => l.kind !== "set")))));
  }

  /** A field that would not be one field in a file: it has a comma, or the # of a comment. */
  checkFields() {
    for (const slot of this.slots) {
      slot.inputs.forEach((input, i) => {
        const text = input.value.trim(), number = input.inputMode === "decimal";
        if (!text.includes("#") && !(number && text.includes(","))) return;
        const what = number ? S.anyNumber : C.textWithout;
        throw Object.assign(new InputError(""), {slot, input: i, words: S.expected(input.getAttribute("aria-label") ||
          input.labels[0].textContent, what, text, number ? hint(text) : "")});
      });
    }
  }

  /** The study, or null, with the fault shown where it stands. */
  read() {
    this.say("");
    for (const {fault, inputs} of this.slots) {
      fault.textContent = "";
      inputs.forEach((input) => input.setAttribute("aria-invalid", "false"));
    }
    const name = C.programme(this.at + 1);
    try {
      this.checkFields();
      const study = readText(name, textOfLines(this.lines), true);
      if (study.knots.length < 2) throw new InputError(`${name}: ${C.noRows}`);
      study.muscle = muscleOf(this.page.law, study, this.page.model.muscle);
      return study;
    } catch (e) {
      if (!(e instanceof InputError)) throw e;
      const line = this.lines[e.row], slot = e.slot || (line && this.slots.find((s) => s.has(line)));
      if (!slot) {
        this.say(e.message);
        return null;
      }
      slot.fault.textContent = e.words;
      const input = slot.inputs[e.slot ? e.input : e.field - 1];
      if (input) input.setAttribute("aria-invalid", "true");
      return null;
    }
  }

  /** What is wrong with the programme as a whole. */
  say(text) {
    this.general.textContent = text;
  }
}
