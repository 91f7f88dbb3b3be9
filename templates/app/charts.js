// Curves over two axes, with the values under the pointer, and a window that is drawn over one of them.
import { el, number } from "./app.js";
import { svg } from "./drawing.js";

const W = 640, H = 230, M = { left: 52, right: 10, top: 10, bottom: 34 };
const COLOURS = ["#0b5cad", "#c76a00", "#b3261e", "#2e7d32", "#7a1fa2", "#00838f", "#5d4037", "#666"];
const ticks = (low, high) => {
  const raw = (high - low) / 5, power = 10 ** Math.floor(Math.log10(raw)), unit = [1, 2, 5, 10].map((k) => k * power).find((each) => each >= raw);
  return Array.from({ length: Math.floor(high / unit + 1e-9) - Math.ceil(low / unit - 1e-9) + 1 }, (_, k) => (Math.ceil(low / unit - 1e-9) + k) * unit);
};
const text = (attributes, said) => Object.assign(svg("text", attributes), { textContent: said });
// series: [{ label, x, y, dashed }]; window: { from, to, set }, drawn by dragging
export const chart = (title, xLabel, yLabel, series, range = null) => {
  const xs = series.flatMap((each) => each.x), ys = series.flatMap((each) => each.y);
  const [low, high] = [Math.min(0, ...xs), Math.max(1e-9, ...xs)], [down, up] = [Math.min(0, ...ys), Math.max(1e-9, ...ys)];
  const X = (x) => M.left + ((x - low) / (high - low)) * (W - M.left - M.right), Y = (y) => H - M.bottom - ((y - down) / (up - down)) * (H - M.top - M.bottom);
  const picture = svg("svg", { class: "chart", viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": title });
  ticks(low, high).forEach((v) => picture.append(svg("line", { class: "grid", x1: X(v), x2: X(v), y1: M.top, y2: H - M.bottom }), text({ x: X(v), y: H - M.bottom + 11 }, number(v))));
  ticks(down, up).forEach((v) => picture.append(svg("line", { class: "grid", x1: M.left, x2: W - M.right, y1: Y(v), y2: Y(v) }), text({ x: M.left - 22, y: Y(v) }, number(v))));
  picture.append(svg("line", { class: "axis", x1: M.left, x2: W - M.right, y1: Y(0), y2: Y(0) }), text({ x: W / 2, y: H - 8 }, xLabel), text({ transform: `translate(10 ${H / 2}) rotate(-90)` }, yLabel));
  series.forEach((each, k) => picture.append(svg("polyline", { stroke: COLOURS[k % 8], "stroke-dasharray": each.dashed ? "5 3" : null,
    points: each.x.map((x, i) => `${X(x).toFixed(1)},${Y(each.y[i]).toFixed(1)}`).join(" ") })));
  const said = el("p", { className: "note" }), legend = () => {
    said.replaceChildren(...series.map((each, k) => { const one = el("span", {}, `— ${each.label}  `); one.style.color = COLOURS[k % 8]; return one; }));
  };
  const at = (event) => { const box = picture.getBoundingClientRect(); return low + (((event.clientX - box.left) / box.width) * W - M.left) / (W - M.left - M.right) * (high - low); };
  const shade = svg("rect", { class: "window", y: M.top, height: H - M.top - M.bottom, width: 0 });
  const mark = (from, to) => { shade.setAttribute("x", X(Math.min(from, to))); shade.setAttribute("width", Math.abs(X(to) - X(from))); };
  if (range) { picture.append(shade); if (range.to > range.from) mark(range.from, range.to); }
  let from = null;
  picture.addEventListener("pointerdown", (event) => { if (range) { from = Math.max(low, at(event)); picture.setPointerCapture(event.pointerId); } });
  picture.addEventListener("pointerup", (event) => {
    const to = Math.min(high, at(event)), begun = from;
    from = null;
    if (begun !== null && Math.abs(to - begun) > 0.01 * (high - low)) range.set([Math.min(begun, to), Math.max(begun, to)].map((t) => +t.toFixed(2)));
  });
  picture.addEventListener("pointermove", (event) => {
    const x = at(event);
    if (from !== null) mark(from, Math.min(Math.max(x, low), high));
    said.textContent = `${xLabel} ${number(x)} · ` + series.map((each) => {
      let k = 0;
      while (k < each.x.length - 1 && each.x[k] < x) k++;
      return `${each.label} ${number(each.y[k])}`;
    }).join(" · ");
  });
  picture.addEventListener("pointerleave", legend);
  legend();
  return el("figure", {}, el("figcaption", {}, title), picture, said);
};
