// The page: starts the law, makes the views, keeps their inputs in the address.
import {h, button} from "./dom.js";
import {PARAMETERS, load} from "./law.js";
import {TABS, defaults, fromFragment, toFragment} from "./model.js";
import {comparePanel} from "./panels/compare.js";
import {designPanel} from "./panels/design.js";
import {fitPanel} from "./panels/fit.js";
import {musclePanel} from "./panels/muscle.js";
import {playPanel} from "./panels/play.js";
import {uncertaintyPanel} from "./panels/uncertainty.js";
import {S} from "./strings.js";
import {faultOf, textOf} from "./text.js";

const MOST_ADDRESS = 2000000; // characters: Chromium takes no more
const MAKE = {play: playPanel, compare: comparePanel, design: designPanel, uncertainty: uncertaintyPanel, fit: fitPanel};

class Page {
  constructor(law) {
    Object.assign(this, {law, model: defaults(), panels: {}, tabs: {}, waiting: 0});
    this.message = h("p", {class: "fault", role: "alert", id: "link_faults"});
    this.note = h("p", {role: "status"});
    this.noResult = h("p", {class: "fault", role: "alert", id: "no_result"});
    this.printed = h("p", {class: "printed"});
    this.muscle = musclePanel(this);
    for (const name of TABS) {
      this.panels[name] = MAKE[name](this);
      Object.entries({id: `panel_${name}`, role: "tabpanel", "aria-labelledby": `tab_${name}`}).forEach(([key, value]) =>
        this.panels[name].element.setAttribute(key, value));
      this.tabs[name] = button(S.tabs[name], () => this.open(name), {role: "tab", id: `tab_${name}`,
        "aria-controls": `panel_${name}`});
    }
  }

  build() {
    const tabs = h("div", {role: "tablist", "aria-label": S.views}, ...TABS.map((name) => this.tabs[name]));
    tabs.addEventListener("keydown", (event) => {
      const step = {ArrowRight: 1, ArrowLeft: -1}[event.key], at = TABS.indexOf(this.model.tab);
      const next = event.key === "Home" ? 0 : event.key === "End" ? TABS.length - 1
        : step && (at + step + TABS.length) % TABS.length;
      if (next === undefined) return;
      event.preventDefault();
      this.open(TABS[next]);
      this.tabs[TABS[next]].focus();
    });
    document.getElementById("page").replaceChildren(
      h("header", {}, h("h1", {}, S.title), h("p", {}, S.lead), h("p", {class: "standing"}, S.standing)), this.message,
      h("div", {class: "bar"}, tabs, button(S.link, () => this.copyLink(), {id: "copy_link"})), this.note,
      h("div", {class: "columns"}, h("aside", {}, this.muscle.element),
        h("main", {}, this.printed, this.noResult, ...TABS.map((name) => this.panels[name].element))),
      h("footer", {}, h("p", {}, S.footer(this.law.version))));
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
      event.preventDefault();
      const files = event.dataTransfer.files;
      if (files.length === 0) return;
      this.open("compare");
      this.panels.compare.open(files);
    });
    addEventListener("hashchange", () => {
      if (location.hash.slice(1) !== toFragment(this.model)) this.fromAddress();
    });
    this.fromAddress();
  }

  fromAddress() {
    const {model, faults} = fromFragment(location.hash.slice(1), this.law);
    this.model = model;
    this.message.replaceChildren(...(faults.length === 0 ? [] : [S.linkFaults, ...faults.map((f) => h("span", {}, " ", f))]));
    this.showAll();
    this.open(model.tab);
  }

  showAll() {
    this.muscle.show();
    for (const panel of Object.values(this.panels)) panel.show();
  }

  open(name) {
    this.model.tab = name;
    for (const other of TABS) {
      const active = other === name;
      this.panels[other].element.hidden = !active;
      this.tabs[other].setAttribute("aria-selected", String(active));
      this.tabs[other].tabIndex = active ? 0 : -1;
      if (!active && this.panels[other].hide) this.panels[other].hide();
    }
    this.panels[name].show();
    this.changed();
  }

  /** An input has changed: the view that is open computes again. */
  changed() {
    this.muscle.show();
    const unit = (name) => S.muscle.units[this.law.table[this.law.index[name]].unit].replace("–", "");
    this.printed.textContent = S.printed(PARAMETERS.filter((name) => !/rev|min/.test(name) || this.model.muscle.tau_rev > 0)
      .map((name) => `${S.muscle.symbols[name]} = ${textOf(this.model.muscle[name])} ${unit(name)}`.trim()).join(", "));
    this.attempt(this.model.tab, () => this.panels[this.model.tab].update());
    this.keep();
  }

  /** Computes what a view shows. If the inputs have no result, that is said, and what is shown of earlier ones is hidden. */
  attempt(name, compute) {
    const why = faultOf(compute);
    if (name === this.model.tab) this.noResult.textContent = why && S.noResult(why);
    this.panels[name].element.classList.toggle("stale", why !== "");
  }

  /** Keeps the inputs in the address, a moment later. */
  keep() {
    clearTimeout(this.waiting);
    this.waiting = setTimeout(() => this.write(), 250);
  }

  write() {
    clearTimeout(this.waiting);
    const fragment = "#" + toFragment(this.model), fits = fragment.length + location.pathname.length < MOST_ADDRESS;
    if (fits) history.replaceState(null, "", fragment);
    this.note.textContent = fits ? "" : S.linkTooLong;
    return fits;
  }

  async copyLink() {
    if (!this.write()) return;
    try {
      await navigator.clipboard.writeText(location.href);
    } catch (e) {
      // Some browsers give pages of a disk no clipboard; the address bar has the link.
    }
    this.note.textContent = S.linkCopied;
  }
}

load(window.MYOGROWTH_WASM).then((law) => {
  document.documentElement.lang = "en";
  const page = new Page(law);
  window.myogrowth = page; // for the tests, and for the curious
  page.build();
}, (e) => document.getElementById("page").append(h("p", {class: "fault", role: "alert"}, S.noLaw(e.message))));
