// Charts by uPlot, in the page's colours, light or dark.
import {h} from "./dom.js";
import {S} from "./strings.js";

const FONT = "14px system-ui, sans-serif";
export const DASHES = [[], [8, 4], [2, 3], [10, 4, 2, 4]];
// Okabe and Ito's colours, darkened where white would not show them: for all eyes, with a dash each.
export const COLOURS = ["blue", "orange", "green", "pink"];

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
export const colour = (i) => css(COLOURS[i % 4]);

/**
 * A chart over time. series: [{label, colour: 0..3, dash: false, width, points: true, hidden: true}]; bands:
 * [[upper, lower], ...], numbers of series. The legend shows the values under the pointer.
 */
export class Chart {
  constructor({title, series, bands, sync, height}) {
    Object.assign(this, {title, series, bands: bands || [], lines: [], data: [[]], sync, height: height || 230});
    this.host = h("div", {class: "plot"});
    this.element = h("figure", {class: "chart"}, h("figcaption", {}, title), this.host);
    new ResizeObserver(() => this.resize()).observe(this.host);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.plot && this.plot.redraw());
  }

  make() {
    const axis = {stroke: () => css("text"), font: FONT, labelFont: FONT, grid: {stroke: () => css("grid")},
      ticks: {stroke: () => css("grid")}};
    const series = this.series.map((s, i) => ({
      label: s.dash === false || s.points ? s.label : `${S.curves.dashes[s.colour % 4]} ${s.label}`,
      stroke: s.hidden ? undefined : () => colour(s.colour), width: s.width || 2,
      dash: s.dash === false ? [] : DASHES[s.colour % 4], points: s.points ? {show: true, size: 8} : {show: false},
      paths: s.points ? () => null : undefined,
      fill: undefined, spanGaps: !s.points, value: (u, v) => v === null || v === undefined ? "–" : v.toFixed(4), index: i,
    }));
    return new uPlot({
      width: Math.max(this.host.clientWidth, 200), height: this.height, data: this.data, pxAlign: 0,
      series: [{label: S.curves.day, value: (u, v) => v === null || v === undefined ? "–" : v.toFixed(2)}, ...series],
      bands: this.bands.map(([upper, lower]) => ({series: [upper + 1, lower + 1],
        fill: () => colour(this.series[upper].colour) + "30"})),
      axes: [Object.assign({label: S.curves.time, labelSize: 22}, axis), Object.assign({size: 62}, axis)],
      scales: {x: {time: false}, y: {range: (u, low, high) => this.range(low, high)}},
      cursor: {sync: this.sync ? {key: this.sync} : undefined, drag: {x: true, y: false}},
      hooks: {draw: [(u) => this.drawLines(u)]},
    }, this.data, this.host);
  }

  range(low, high) {
    const all = this.lines.map((l) => l.value).concat(low, high).filter((v) => v !== null && isFinite(v));
    const a = Math.min(...all), b = Math.max(...all);
    const room = Math.max(0.05 * (b - a), 1e-4 * Math.max(Math.abs(a), Math.abs(b))) || 0.01;
    return [a - room, b + room];
  }

  drawLines(u) {
    for (const line of this.lines) {
      const y = u.valToPos(line.value, "y", true), x0 = u.bbox.left, x1 = x0 + u.bbox.width, c = u.ctx;
      c.save();
      c.strokeStyle = c.fillStyle = css("text");
      c.setLineDash([3, 4].map((v) => v * devicePixelRatio));
      c.beginPath();
      c.moveTo(x0, y);
      c.lineTo(x1, y);
      c.stroke();
      c.font = `${14 * devicePixelRatio}px system-ui, sans-serif`;
      c.textAlign = "right";
      c.fillText(line.label, x1 - 4, y - 4 * devicePixelRatio);
      c.restore();
    }
  }

  /** New curves: the times, and an array for each series. lines: [{value, label}], horizontal. */
  set(time, columns, lines = [], series = null) {
    if (series) {
      this.series = series;
      if (this.plot) this.plot.destroy();
      this.plot = null;
    }
    this.lines = lines;
    this.data = [separate(time), ...columns];
    if (!this.plot) {
      if (this.host.clientWidth === 0) return; // not in view yet: resize() makes it
      this.plot = this.make();
    } else {
      this.plot.setData(this.data);
    }
    this.describe();
  }

  describe() {
    const canvas = this.plot.ctx.canvas;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", this.series.map((s, k) => {
      const values = Array.from(this.data[k + 1]).filter((v) => v !== null);
      return values.length === 0 ? "" : S.curves.summary(this.title, s.label, values[0], values[values.length - 1],
        values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b)));
    }).join(" "));
  }

  resize() {
    if (this.host.clientWidth === 0 || this.data[0].length === 0) return;
    if (!this.plot) {
      this.plot = this.make();
      this.describe();
    }
    if (this.plot.width !== this.host.clientWidth) this.plot.setSize({width: this.host.clientWidth, height: this.height});
  }
}

/** Times that increase: of two of the same time, a step, the second is drawn a second later. */
function separate(time) {
  const t = Float64Array.from(time);
  for (let i = 1; i < t.length; ++i) if (t[i] <= t[i - 1]) t[i] = t[i - 1] + 1e-5;
  return t;
}
