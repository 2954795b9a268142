// Elements, and the fields for numbers: a slider beside a text, which says what is wrong where it stands.
import {S} from "./strings.js";
import {hint, textOf, toNumber} from "./text.js";

let ids = 0;
export const newId = () => `e${++ids}`;

/** An element: h("p", {class: "x", onclick: f}, "text", child, ...). */
export function h(tag, attributes, ...children) {
  const svg = tag.startsWith("svg:");
  const e = svg ? document.createElementNS("http://www.w3.org/2000/svg", tag.slice(4)) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name.startsWith("on")) e.addEventListener(name.slice(2), value);
    else if (value === true) e.setAttribute(name, "");
    else if (value !== false && value !== undefined && value !== null) e.setAttribute(name, value);
  }
  e.append(...children.filter((c) => c !== null && c !== undefined));
  return e;
}

export function button(text, onclick, attributes) {
  return h("button", Object.assign({type: "button", onclick}, attributes), text);
}

/** A table with a heading row; the first cell of every row is its heading. */
export function table(caption, columns, rows) {
  return h("div", {class: "scroll", tabindex: 0, role: "region", "aria-label": caption},
    h("table", {}, h("caption", {}, caption), h("thead", {}, h("tr", {}, ...columns.map((c) => h("th", {scope: "col"}, c)))),
      h("tbody", {}, ...rows.map((row) => h("tr", {}, ...row.map((cell, i) =>
        i === 0 ? h("th", {scope: "row"}, cell) : h("td", {}, cell)))))));
}

/**
 * A number of the model. spec: {label, unit, key, least, most, slider: [low, high, step], log, get(), set(x),
 * fault(x): a text or null}. Returns {element, show()}: show() takes the value from the model.
 */
export function field(spec) {
  const id = newId(), faultId = newId();
  const input = h("input", {id, type: "text", inputmode: "decimal", autocomplete: "off", name: spec.key,
    "aria-describedby": faultId});
  const fault = h("p", {class: "fault", id: faultId, role: "alert"});
  const [low, high, step] = spec.slider || [], factor = Math.log(high / low);
  const slider = spec.slider && h("input", Object.assign({type: "range", "aria-label": S.slider(spec.label),
    name: spec.key && `${spec.key}_slider`}, spec.log ? {min: 0, max: 1, step: 0.005} : {min: low, max: high, step}));
  const toSlider = (x) => spec.log ? Math.log(x / low) / factor : x;
  const fromSlider = (s) => Number(spec.log ? (low * Math.exp(factor * s)).toPrecision(3) : s.toPrecision(10));
  const say = (text) => {
    fault.textContent = text;
    input.setAttribute("aria-invalid", text ? "true" : "false");
  };
  const showSlider = (x) => {
    if (!slider) return;
    slider.value = toSlider(x);
    slider.setAttribute("aria-valuetext", `${textOf(x)} ${spec.unit || ""}`);
  };
  const take = (x) => {
    const wrong = spec.fault && spec.fault(x);
    say(wrong || "");
    if (wrong) return;
    showSlider(x);
    spec.set(x);
  };
  input.addEventListener("input", () => {
    const text = input.value.trim(), x = toNumber(text), bounded = spec.least !== undefined;
    if (Number.isNaN(x) || (bounded && !(x >= spec.least && x <= spec.most))) {
      say(S.expected(spec.label, bounded ? S.number(spec.least, spec.most) : S.anyNumber, text, hint(text)));
    } else {
      take(x);
    }
  });
  if (slider) {
    slider.addEventListener("input", () => {
      const x = fromSlider(Number(slider.value));
      input.value = textOf(x);
      take(x);
    });
  }
  const show = () => {
    const x = spec.get();
    if (document.activeElement !== input || toNumber(input.value.trim()) !== x) {
      input.value = textOf(x);
      say("");
    }
    if (document.activeElement !== slider) showSlider(x);
  };
  show();
  const element = h("div", {class: "field"}, h("label", {for: id}, spec.label), slider || null, input,
    h("span", {class: "unit"}, spec.unit || ""), fault);
  return {element, show};
}

/** Hands a file to the user. */
export function save(name, blob) {
  const url = URL.createObjectURL(blob), a = h("a", {href: url, download: name});
  document.body.append(a);
  a.click();
  a.remove();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

export function saveText(name, text, type = "text/csv") {
  save(name, new Blob([text], {type}));
}
