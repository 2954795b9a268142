// Curves of charts as files: SVG and PNG.
import {COLOURS, DASHES} from "./chart.js";
import {h, save, saveText} from "./dom.js";
import {S} from "./strings.js";

// XML has no U+FFFE and U+FFFF.
const escape = (text) => text.replace(/[\ufffe\uffff]/g, "\ufffd")
  .replace(/[&<>"]/g, (c) => ({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;"}[c]));

/** About n round numbers from low to high. */
function ticks(low, high, n) {
  const raw = (high - low) / n, power = Math.pow(10, Math.floor(Math.log10(raw)));
  const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= raw);
  const found = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; ++k) found.push(Number((k * step).toPrecision(10)));
  return found;
}

/** A text in lines of at most n characters, at blanks where there are some. */
function wrapped(text, n) {
  return text.match(new RegExp(`.{1,${n}}(?=\\s|$)|\\S{${n}}`, "gu")).map((line) => line.trim()).filter((line) => line);
}

/** The charts one below the other, as SVG, on white; then what the curves are, notes, and the standing sentence. */
export function svgOf(charts, notes) {
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
    });
  });
  let y = charts.length * H + 6;
  const say = (words) => {
    for (const line of wrapped(words, 85)) parts.push(`<text x="${left}" y="${y += 20}">${escape(line)}</text>`);
  };
  for (const s of charts[0].series) {
    parts.push(`<path d="M10,${y + 15}h60" stroke="${names[COLOURS[s.colour % 4]]}" stroke-width="2" ` +
      `stroke-dasharray="${DASHES[s.colour % 4].join(" ")}"/>`);
    say(s.label);
  }
  notes.concat(S.standing).forEach(say);
  const height = y + 14;
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${W}" height="${height}" viewBox="0 0 ${W} ${height}" ` +
    `font-family="sans-serif" font-size="14"><rect width="100%" height="100%" fill="#fff"/>${parts.join("\n")}</svg>`;
}

export function saveSvg(name, charts, notes) {
  saveText(name, svgOf(charts, notes), "image/svg+xml");
}

export async function savePng(name, charts, notes) {
  const picture = new Image();
  picture.src = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(svgOf(charts, notes));
  await picture.decode();
  const canvas = h("canvas", {width: 2 * picture.width, height: 2 * picture.height});
  canvas.getContext("2d").drawImage(picture, 0, 0, canvas.width, canvas.height);
  canvas.toBlob((blob) => save(name, blob), "image/png");
}
