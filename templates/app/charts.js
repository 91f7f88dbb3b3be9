// Curves over two axes, with the values under the pointer, and a window that is drawn over one of them.
import { el, number } from "./app.js";
import { svg } from "./drawing.js";

const W = 640, H = 230, M = { left: 52, right: 10, top: 10, bottom: 34 };
const COLOURS = ["#0b5cad", "#c76a00", "#b3261e", "#2e7d32", "#7a1fa2", "#00838f", "#5d4037", "#666"];
const text = (attributes, said) => Object.assign(svg("text", attributes), { textContent: said });
const ticks = (low, high) => {
  const raw = (high - low) / 5, power = 10 ** Math.floor(Math.log10(raw));
  const unit = [1, 2, 5, 10].map((k) => k * power).find((each) => each >= raw);
  const found = [];
  for (let k = Math.ceil(low / unit - 1e-9); k * unit <= high + 1e-9 * unit; k++) found.push(k * unit);
  return found;
};

// series: [{ label, x, y, dashed }]; range: { from, to, set } of a window, drawn by dragging
export const chart = (title, xLabel, yLabel, series, range = null) => {
  const xs = series.flatMap((each) => each.x), ys = series.flatMap((each) => each.y);
  const [low, high] = [Math.min(0, ...xs), Math.max(1e-9, ...xs)];
  const [down, up] = [Math.min(0, ...ys), Math.max(1e-9, ...ys)];
  const [width, height] = [W - M.left - M.right, H - M.top - M.bottom];
  const X = (x) => M.left + ((x - low) / (high - low)) * width;
  const Y = (y) => H - M.bottom - ((y - down) / (up - down)) * height;
  const picture = svg("svg", { class: "chart", viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": title });
  const line = (name, x1, y1, x2, y2) => svg("line", { class: name, x1, y1, x2, y2 });
  for (const v of ticks(low, high)) {
    picture.append(line("grid", X(v), M.top, X(v), H - M.bottom), text({ x: X(v), y: H - M.bottom + 11 }, number(v)));
  }
  for (const v of ticks(down, up)) {
    picture.append(line("grid", M.left, Y(v), W - M.right, Y(v)), text({ x: M.left - 22, y: Y(v) }, number(v)));
  }
  picture.append(line("axis", M.left, Y(0), W - M.right, Y(0)), text({ x: W / 2, y: H - 8 }, xLabel),
    text({ transform: `translate(10 ${H / 2}) rotate(-90)` }, yLabel));
  series.forEach((each, k) => {
    const points = each.x.map((x, i) => `${X(x).toFixed(1)},${Y(each.y[i]).toFixed(1)}`).join(" ");
    picture.append(svg("polyline", { stroke: COLOURS[k % 8], "stroke-dasharray": each.dashed ? "5 3" : null, points }));
  });

  const said = el("p", { className: "note" });
  const legend = () => said.replaceChildren(...series.map((each, k) => {
    const one = el("span", {}, `— ${each.label}  `);
    one.style.color = COLOURS[k % 8];
    return one;
  }));
  const at = (event) => {
    const box = picture.getBoundingClientRect(), x = ((event.clientX - box.left) / box.width) * W;
    return low + ((x - M.left) / width) * (high - low);
  };
  picture.addEventListener("pointermove", (event) => {
    const x = at(event), values = series.map((each) => {
      const k = each.x.findIndex((value) => value >= x);
      return `${each.label} ${number(each.y.at(k))}`;
    });
    said.textContent = [`${xLabel} ${number(x)}`, ...values].join(" · ");
  });
  picture.addEventListener("pointerleave", legend);
  legend();
  if (range) picture.append(windowed(picture, range, { at, X, low, high, height }));
  return el("figure", {}, el("figcaption", {}, title), picture, said);
};
const windowed = (picture, range, { at, X, low, high, height }) => {
  const shade = svg("rect", { class: "window", y: M.top, height, width: 0 });
  const mark = (from, to) => {
    shade.setAttribute("x", X(Math.min(from, to)));
    shade.setAttribute("width", Math.abs(X(to) - X(from)));
  };
  const within = (event) => Math.min(Math.max(at(event), low), high);
  let from = null;
  picture.addEventListener("pointerdown", (event) => {
    from = within(event);
    picture.setPointerCapture(event.pointerId);
  });
  picture.addEventListener("pointermove", (event) => { if (from !== null) mark(from, within(event)); });
  picture.addEventListener("pointerup", (event) => {
    const ends = [from, within(event)].sort((a, b) => a - b);
    from = null;
    if (ends[1] - ends[0] > 0.01 * (high - low)) range.set(ends.map((t) => +t.toFixed(2)));
  });
  if (range.to > range.from) mark(range.from, range.to);
  return shade;
};
