// A picture of sarcomeres in series: as long as the muscle, each as long as the elastic stretch; new ones in a colour of
// their own.
import {h} from "./dom.js";
import {S} from "./strings.js";

const FIRST = 12, MOST = 200, WIDTH = 1000, HEIGHT = 120;

export class Sarcomeres {
  constructor() {
    this.svg = h("svg:svg", {viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "sarcomeres", role: "img",
      preserveAspectRatio: "xMinYMid meet"});
    this.text = h("p", {class: "note", "aria-live": "off"});
    this.element = h("div", {class: "picture"}, this.svg, this.text);
  }

  /** longest: the largest stretch of the history, for the scale. */
  show(stretch, G, longest) {
    const unit = (WIDTH - 20) / Math.max(longest, 1.05) / FIRST, n = FIRST * G, width = unit * stretch / G;
    const parts = [h("svg:path", {class: "rest", d: `M10,16v-8h${FIRST * unit}v8`})];
    const middle = 68, half = 34;
    for (let i = 0; i < Math.min(n, MOST) - 1e-6; ++i) {
      const part = Math.min(1, n - i), x = 10 + i * width, w = part * width, rod = 0.55 * unit * Math.min(1, part);
      const group = h("svg:g", {class: i >= FIRST - 1e-6 ? "new" : "old"},
        h("svg:rect", {x: x + 1, y: middle - half, width: Math.max(w - 2, 0.5), height: 2 * half, rx: 3}));
      for (const y of [-18, 0, 18]) {
        group.append(h("svg:path", {class: "thin", d: `M${x + 1},${middle + y - 7}h${0.42 * unit * part}m${w - 2 -
          0.84 * unit * part},0h${0.42 * unit * part}`}));
        group.append(h("svg:path", {class: "thick", d: `M${x + (w - rod) / 2},${middle + y}h${rod}`}));
      }
      parts.push(group);
    }
    this.svg.replaceChildren(...parts);
    const words = n > MOST ? S.play.tooMany(n, MOST) : S.play.drawn(n, n - FIRST);
    this.svg.setAttribute("aria-label", words);
    this.text.textContent = words;
  }
}
