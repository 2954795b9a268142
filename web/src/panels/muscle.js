// The muscle's parameters, for all views: presets, the six of the model, and removal's four.
import {field, h, newId} from "../dom.js";
import {PRESETS} from "../presets.js";
import {S} from "../strings.js";
import {paper} from "../model.js";

const SLIDERS = {c1: [1, 100, 0.5], c2: [0.5, 50, 0.5], tau: [0.05, 20, 0], gamma: [0, 8, 0.1], G_max: [1.02, 3, 0.01],
  lambda_crit: [0.98, 1.1, 0.001]};

export function musclePanel(page) {
  const {law} = page, fields = [];
  const make = (name) => {
    const entry = law.table[law.index[name]];
    const f = field({
      key: name, label: `${S.muscle.symbols[name]}: ${entry.meaning.split(";")[0]}`, unit: S.muscle.units[entry.unit],
      slider: SLIDERS[name], log: name === "tau",
      get: () => page.model.muscle[name],
      set: (x) => {
        page.model.muscle[name] = x;
        page.changed();
      },
      fault: (x) => {
        const fault = law.fault(Object.assign({}, page.model.muscle, {[name]: x}));
        return fault && fault.text;
      },
    });
    fields.push(f);
    return f.element;
  };
  const id = newId(), source = h("p", {class: "note"});
  const select = h("select", {id, name: "preset"}, h("option", {value: ""}, S.muscle.own),
    ...PRESETS.map((p) => h("option", {value: p.id}, p.title)));
  select.addEventListener("change", () => {
    const preset = PRESETS.find((p) => p.id === select.value);
    if (!preset) return;
    Object.assign(page.model.muscle, paper(), preset.values);
    page.changed();
    show();
  });
  const matching = () => PRESETS.find((p) => Object.entries(Object.assign(paper(), p.values))
    .every(([name, x]) => page.model.muscle[name] === x));
  function show() {
    fields.forEach((f) => f.show());
    const preset = matching();
    select.value = preset ? preset.id : "";
    source.textContent = preset ? S.muscle.source(preset.source) : "";
  }
  const names = Object.keys(SLIDERS), removal = ["tau_rev", "gamma_rev", "G_min", "lambda_crit_rev"];
  const element = h("details", {class: "muscle", open: innerWidth > 820}, h("summary", {}, h("h2", {}, S.muscle.heading)),
    h("div", {class: "field"}, h("label", {for: id}, S.muscle.preset), select), source, ...names.map(make),
    h("details", {}, h("summary", {}, S.muscle.removal), ...removal.map(make)));
  return {element, show};
}
