// Charts by uPlot, in the page's colours, light or dark; and the same curves as SVG and PNG.
import {h, save, saveText} from "./dom.js";
import {S} from "./strings.js";

const FONT = "14px system-ui, sans-serif", DASHES = [[], [8, 4], [2, 3], [10, 4, 2, 4]];
// Okabe and Ito's colours, darkened where white would not show them: for all eyes, with a dash each.
const COLOURS = ["blue", "orange", "green", "pink"];

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
      label: s.label, stroke: s.hidden ? undefined : () => colour(s.colour), width: s.width || 2,
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
    const a = Math.min(...all), b = Math.max(...all), room = 0.05 * (b - a) || 0.01;
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

// ---- As a file

const escape = (text) => text.replace(/[&<>"]/g, (c) => ({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;"}[c]));

/** About n round numbers from low to high. */
function ticks(low, high, n) {
  const raw = (high - low) / n, power = Math.pow(10, Math.floor(Math.log10(raw)));
  const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= raw);
  const found = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; ++k) found.push(Number((k * step).toPrecision(10)));
  return found;
}

/** The charts one below the other, as SVG, on white. */
export function svgOf(charts) {
  const W = 800, H = 300, left = 80, right = 20, top = 30, bottom = 50, parts = [];
  const names = {blue: "#0072b2", orange: "#b84e00", green: "#00795a", pink: "#a8437f"};
  charts.forEach((chart, at) => {
    const [time, ...columns] = chart.data, y0 = at * H + top, width = W - left - right, height = H - top - bottom;
    const values = columns.reduce((all, c) => all.concat(Array.from(c)), []).filter((v) => v !== null && isFinite(v));
    const extremes = values.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
    const [low, high] = chart.range(...extremes), end = time[time.length - 1] || 1;
    const X = (t) => (left + width * (t - time[0]) / (end - time[0])).toFixed(2);
    const Y = (v) => (y0 + height * (high - v) / (high - low)).toFixed(2);
    const text = (x, y, words, anchor) => `<text x="${x}" y="${y}" text-anchor="${anchor}">${escape(words)}</text>`;
    parts.push(text(left, y0 - 10, chart.title, "start"), text(left + width / 2, y0 + height + 42, S.curves.time, "middle"));
    for (const t of ticks(time[0], end, 8)) {
      parts.push(`<path d="M${X(t)},${y0}v${height}" stroke="#ddd"/>`, text(X(t), y0 + height + 20, String(t), "middle"));
    }
    for (const v of ticks(low, high, 5)) {
      parts.push(`<path d="M${left},${Y(v)}h${width}" stroke="#ddd"/>`, text(left - 8, Number(Y(v)) + 5, String(v), "end"));
    }
    for (const line of chart.lines) {
      parts.push(`<path d="M${left},${Y(line.value)}h${width}" stroke="#000" stroke-dasharray="3 4"/>`,
        text(left + width - 4, Number(Y(line.value)) - 4, line.label, "end"));
    }
    chart.series.forEach((s, k) => {
      const points = [];
      time.forEach((t, i) => { if (columns[k][i] !== null) points.push(`${X(t)},${Y(columns[k][i])}`); });
      const stroke = names[COLOURS[s.colour % 4]];
      parts.push(`<polyline points="${points.join(" ")}" fill="none" stroke="${stroke}" stroke-width="2" ` +
        `stroke-dasharray="${DASHES[s.colour % 4].join(" ")}"/>`);
      if (at === 0) parts.push(`<text x="${left + width - 6}" y="${y0 + 18 + 18 * k}" text-anchor="end" fill="${stroke}">` +
        `${escape(s.label)}</text>`);
    });
  });
  const height = charts.length * H + 34;
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${W}" height="${height}" viewBox="0 0 ${W} ${height}" ` +
    `font-family="sans-serif" font-size="14"><rect width="100%" height="100%" fill="#fff"/>${parts.join("\n")}` +
    `${`<text x="${left}" y="${height - 12}">${escape(S.standing)}</text>`}</svg>`;
}

export function saveSvg(name, charts) {
  saveText(name, svgOf(charts), "image/svg+xml");
}

export async function savePng(name, charts) {
  const picture = new Image();
  picture.src = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(svgOf(charts));
  await picture.decode();
  const canvas = h("canvas", {width: 2 * picture.width, height: 2 * picture.height});
  canvas.getContext("2d").drawImage(picture, 0, 0, canvas.width, canvas.height);
  canvas.toBlob((blob) => save(name, blob), "image/png");
}
