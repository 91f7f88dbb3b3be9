// The drawing: blocks, joints and faults; what is chosen, measured and placed in it; a support that is dragged.
// Points are (x, z) in m, z upwards: SVG's y is −z.
import { $, ask, attempt, choose, content, edit, el, note, number, ready, store, w } from "./app.js";

const NS = "http://www.w3.org/2000/svg";
export const svg = (tag, attributes = {}, ...children) => {
  const made = document.createElementNS(NS, tag);
  for (const [key, value] of Object.entries(attributes)) if (value !== null) made.setAttribute(key, value);
  made.append(...children);
  return made;
};
const TOOLS = ["select", "lasso", "control", "chain", "crack", "measure"];
const view = { x: 0, y: 0, w: 1, h: 1, metre: 1 }, layer = { joints: false, numbers: false };
let held = null, awaited = null, given_up = 0, fitted = null, shapes = [], parts = null, press = null, trail = [], at = null, drag = null, times = 1;
const root = () => $("drawing");
const blocks = () => store.model?.blocks ?? [];
const path = (points, open) => `M${points.map(([x, z]) => `${x},${-z}`).join("L")}${open ? "" : "Z"}`;
const centre = (block) => block.centre ?? [0, 1].map((i) => block.at.reduce((sum, p) => sum + p[i], 0) / block.at.length);
const place = (event) => {
  const box = press?.box ?? root().getBoundingClientRect(), m = view.metre;
  return [view.x + view.w / 2 + (event.clientX - box.left - box.width / 2) * m,
    -(view.y + view.h / 2 + (event.clientY - box.top - box.height / 2) * m)];
};

// ---- what is drawn ----
export const fit = () => {
  const points = blocks().flatMap((block) => block.at);
  if (!points.length) return;
  const [xs, zs] = [0, 1].map((i) => points.map((p) => p[i]));
  const [x0, z0, x1, z1] = [Math.min(...xs), Math.min(...zs), Math.max(...xs), Math.max(...zs)];
  const room = 0.08 * Math.max(x1 - x0, z1 - z0, 1e-3);
  const tools = Math.min($("tools").offsetHeight / Math.max(root().clientHeight, 1), 0.5);  // their part of the height
  const h = (z1 - z0 + 2.4 * room) / (1 - tools);
  Object.assign(view, { x: x0 - room, y: -z1 - room - tools * h, w: x1 - x0 + 2 * room, h });
  frame();
};
const frame = () => {  // signs keep their size on the screen
  const { clientWidth: width, clientHeight: height } = root();
  root().setAttribute("viewBox", `${view.x} ${view.y} ${view.w} ${view.h}`);
  const m = view.metre = Math.max(view.w / Math.max(width, 1), view.h / Math.max(height, 1));  // of a pixel
  root().querySelectorAll("[data-r]").forEach((each) => each.setAttribute("r", each.dataset.r * m));
  root().querySelectorAll("text").forEach((each) => each.setAttribute("font-size", 12 * m));
};
export const show = () => {
  parts = Object.fromEntries(["ghost", "blocks", "joints", "signs", "faults", "moving", "trail"].map((name) => [name, svg("g")]));
  root().replaceChildren(...Object.values(parts));
  if (at >= blocks().length) at = null;
  shapes = blocks().map((block, index) => svg("path", { d: path(block.at, block.open), "data-block": index }));
  parts.blocks.append(...shapes);
  root().dataset.blocks = shapes.length;
  if (shapes.length && fitted !== store.state.folder) { fitted = store.state.folder; fit(); }
  delete root().dataset.moved;
  if (held && held.digest === store.state.digest && held.answer.positions.length === shapes.length) moved(held.answer);
  parts.faults.replaceChildren(...(store.model?.faults ?? []).flatMap((fault, k) => [
    ...fault.lines.map((line) => svg("path", { class: "fault", d: path(line, true) })),
    ...(fault.points.length ? [svg("circle", { class: "number", cx: fault.points[0][0], cy: -fault.points[0][1], "data-r": 9 }),
      lettered(fault.points[0], k + 1, "0", "fault")] : [])]));
  signs();
  mark();
};
const lettered = ([x, z], text, dy = "-1.2em", name = null) =>
  Object.assign(svg("text", { x, y: -z, dy, class: name }), { textContent: text });
const signs = () => {
  const file = content(), made = [], spot = (each, name, r) => [
    svg("circle", { class: name, cx: each.point_m[0], cy: -each.point_m[1], "data-r": r }), lettered(each.point_m, each.name)];
  const joints = layer.joints ? store.model?.joints ?? [] : [];
  parts.joints.replaceChildren(...joints.map((joint) => svg("path", { class: "joint", d: path(joint.at, true) })));
  if (layer.numbers) blocks().forEach((block, k) => made.push(lettered(centre(block), k, "0")));
  file.region?.forEach((each) => made.push(svg("path", { class: "region", d: path(each.outline_m) })));
  file.tie?.forEach((each) => made.push(svg("path", { class: "tie", d: path([each.from_m, each.to_m], true) })));
  file.measurement?.forEach((each) => made.push(...spot(each, "hinge", 4)));
  file.control?.forEach((each) => made.push(...spot(each, "control", 5)));
  parts.signs.replaceChildren(...made);
  frame();
};
export const mark = () => {
  const { selection } = store, layers = content().layers ?? {};
  shapes.forEach((shape, index) => {
    const block = blocks()[index];
    const chosen = selection && (selection.blocks ? selection.blocks.includes(index) : selection.layer === block.layer);
    shape.setAttribute("class", ["block", block.support && "support", block.open && "open", chosen && "chosen",
      layers[block.layer]?.ignore && "ignored", at === index && "at"].filter(Boolean).join(" "));
  });
};
export const look = ([x, z]) => {
  Object.assign(view, { x: x - view.w / 8, y: -z - view.h / 8, w: view.w / 4, h: view.h / 4 });
  frame();
};
const zoom = (factor, [x, z]) => {
  const now = view.w * factor;
  if (now < 1e-4 || now > 1e5) return;
  Object.assign(view, { x: x + (view.x - x) * factor, y: -z + (view.y + z) * factor, w: now, h: view.h * factor });
  frame();
};
const middle = () => [view.x + view.w / 2, -(view.y + view.h / 2)];

// ---- tools ----
export const render = () => {
  const open = Boolean(store.state.folder);
  const button = (name, text, pressed, onclick) => el("button", { type: "button", "data-tool": name,
    "aria-pressed": pressed === null ? null : String(pressed), title: w(`tool_${name}`), onclick }, text);
  const tool = (name) => { store.tool = name; trail = []; drawTrail(); render(); $("caption").textContent = w(`tool_${name}`); };
  $("tools").replaceChildren(...(open ? [
    ...TOOLS.map((name) => button(name, w(name), store.tool === name, () => tool(name))), button("fit", w("fit"), null, fit),
    button("nearer", "+", null, () => zoom(0.8, middle())), button("wider", "−", null, () => zoom(1.25, middle())),
    ...Object.keys(layer).map((name) => button(name, w(name), layer[name], () => { layer[name] = !layer[name]; render(); })),
    el("select", { id: "times", title: w("times"), "aria-label": w("times"), onchange: magnify },
      ...[1, 2, 5, 10, 20, 50].map((n) => el("option", { value: n, selected: n === times }, `× ${n}`)))] : []));
  root().setAttribute("aria-label", w("drawing_help"));
  root().classList.toggle("moves", store.step === "settlements" && ready());
  root().style.display = open ? "" : "none";
  if (open && parts) { signs(); mark(); }
};
const magnify = (event) => { times = +event.target.value; home(); };
const named = (index) => {
  const { layer, support } = blocks()[index];
  return `${w("block")} ${index} · ${layer}${typeof support === "string" ? ` · ${w("support")} ${support}` : ""}`;
};
const tip = (event) => {
  const index = event.target.dataset?.block, block = blocks()[index];
  $("tip").hidden = !block || Boolean(drag);
  if ($("tip").hidden) return;
  $("tip").textContent = named(index) + (block.weight === undefined ? "" : `\n${number(block.weight, 4)} kN`);
  $("tip").style.left = `${Math.min(event.clientX + 14, innerWidth - 190)}px`;
  $("tip").style.top = `${event.clientY + 16}px`;
};
const within = ([x, z], outline) => outline.reduce((inside, [x1, z1], k) => {
  const [x2, z2] = outline[(k + 1) % outline.length];
  return (z1 > z) !== (z2 > z) && x < x1 + ((z - z1) / (z2 - z1)) * (x2 - x1) ? !inside : inside;
}, false);
const nearest = (point, points, pixels) => {
  let best = null, least = pixels * view.metre;
  for (const each of points) {
    const off = Math.hypot(each[0] - point[0], each[1] - point[1]);
    if (off < least) [least, best] = [off, each];
  }
  return best;
};
const rounded = (point) => point.map((value) => +value.toFixed(4));
const corner = (point) => rounded(nearest(point, blocks().flatMap((block) => block.at), 10) ?? point);
export const freeName = (table, stem) => {
  const names = new Set((content()[table] ?? []).map((each) => each.name));
  let n = 1;
  while (names.has(`${stem}${n}`)) n++;
  return `${stem}${n}`;
};
export const add = (table, entry) => edit(() => [[[table, content()[table]?.length ?? 0], entry()]]);

const click = (event, index) => {
  const point = place(event), { tool } = store;
  if (tool === "select") choose(index === undefined ? null : event.altKey ? { blocks: [+index] } : { layer: blocks()[index].layer });
  else if (tool === "control") {
    const point_m = corner(point);
    add("control", () => ({ name: freeName("control", "C"), point_m }));
  }
  else if (tool === "crack") {
    const end = nearest(point, store.model.joints.flatMap((joint) => joint.at), 14);
    if (!end) return note(w("no_joint_here"));
    const measured = { kind: "crack", point_m: rounded(end), opening_mm: 1, sigma_mm: 0.5 };
    add("measurement", () => ({ name: freeName("measurement", `${w("crack")} `), ...measured }));
  } else if (tool === "chain" || tool === "measure") {
    trail = trail.length === 2 ? [corner(point)] : [...trail, corner(point)];
    if (trail.length === 2 && tool === "chain") {
      const [from_m, to_m] = trail;
      add("tie", () => ({ name: freeName("tie", `${w("chain")} `), from_m, to_m }));
      trail = [];
    } else if (trail.length === 2) {
      const [dx, dz] = [0, 1].map((i) => trail[1][i] - trail[0][i]);
      $("caption").textContent = `${number(Math.hypot(dx, dz), 5)} m (Δx ${number(dx, 5)}, Δz ${number(dz, 5)})`;
    }
    drawTrail();
  }
};
const drawTrail = () => {
  const lasso = store.tool === "lasso";
  parts?.trail.replaceChildren(...(trail.length ? [svg("path", { class: lasso ? "lasso" : "measure", d: path(trail, !lasso) }),
    ...(lasso ? [] : trail.map(([x, z]) => svg("circle", { class: "control", cx: x, cy: -z, "data-r": 4 })))] : []));
  frame();
};
const lassoed = () => {
  const every = Math.max(1, Math.ceil(trail.length / 60)), outline = trail.filter((_, k) => k % every === 0).map(rounded);
  const found = [...blocks().keys()].filter((k) => within(centre(blocks()[k]), outline));
  trail = [];
  drawTrail();
  choose(outline.length > 2 && found.length ? { blocks: found, outline } : null);
};

// ---- a support that is dragged ----
const live = (own, target, more) => ask("live", { tag: store.model.tag, support: own.support, target, ...more });
const moved = (answer) => {
  shapes.forEach((shape, k) => {
    const [dx, dz, turn] = answer.positions[k].map((value) => times * value), [cx, cz] = centre(blocks()[k]);
    const way = `translate(${dx} ${-dz}) rotate(${(-turn * 180) / Math.PI} ${cx} ${-cz})`;
    if (shape.getAttribute("transform") !== way) shape.setAttribute("transform", way);
  });
  if (!parts.ghost.childNodes.length) {
    parts.ghost.append(svg("path", { class: "ghost", d: blocks().map((block) => path(block.at)).join("") }));
    parts.joints.style.display = parts.signs.style.display = "none";
  }
  const { hinges, reaction, at, fallen, stopped } = answer, size = hinges.length > 60 ? 2 : 3.5;
  parts.moving.replaceChildren(...(times === 1 ? hinges : []).map(([x, z]) =>
    svg("circle", { class: "hinge", cx: x, cy: -z, "data-r": size, r: size * view.metre })));
  const [x, z, turn] = at.map((value) => number(1e3 * value, 4)), most = Math.max(...at.slice(0, 2).map(Math.abs));
  const end = stopped === null ? "" : fallen ? w("falls", { mm: number(1e3 * most, 4) }) : stopped[store.language];
  $("caption").className = stopped === null ? "" : "fallen";
  $("caption").textContent = [w("preview"), `${x}; ${z} mm${at[2] ? `; ${turn} mrad` : ""}`,
    `Rx ${number(reaction[0], 4)} Rz ${number(reaction[1], 4)} kN`, w("hinges", { n: hinges.length }), end,
  ].filter(Boolean).join(" · ");
  root().dataset.moved = at.slice(0, 2).map((value) => (1e3 * value).toFixed(1)).join(";");
};
const drawn = (answer) => {  // with the next frame, while the next answer is computed already
  if (!awaited) requestAnimationFrame(() => {
    if (awaited) moved(awaited);
    if (awaited && drag?.slow) $("caption").textContent = w("slow");
    awaited = null;
  });
  awaited = answer;
};
export const home = () => {
  held = awaited = null;
  if (!parts) return;
  shapes.forEach((shape) => shape.removeAttribute("transform"));
  parts.ghost.replaceChildren();
  parts.moving.replaceChildren();
  parts.joints.style.display = parts.signs.style.display = "";
  $("caption").textContent = $("caption").className = "";
  delete root().dataset.moved;
};
const take = (support, from, keys = false) => {
  home();
  drag = { support, from, keys, target: [0, 0, 0], asked: null, first: true };
};
const chase = async () => {  // one question at a time, for where the pointer is by then
  const own = drag;
  if (own.busy) return;
  own.busy = true;
  while (drag === own && !own.slow && String(own.asked) !== String(own.target)) {
    const target = [...own.target], began = performance.now(), { model } = store;
    const answer = await attempt(() => live(own, target, { home: own.first }));
    if (!answer || drag !== own || model !== store.model) break;  // the next movement of the pointer asks again
    own.least = Math.min(own.least ?? Infinity, own.first ? Infinity : answer.cost);
    own.slow = Number.isFinite(own.least) && own.least > 0.15;  // the shape then comes on release
    own.first = false;
    root().dataset.trip = Math.round(performance.now() - began);
    if (answer.there || answer.stopped !== null) own.asked = target;
    drawn(answer);
  }
  own.busy = false;
};
const lead = (target) => { drag.target = target; chase(); };
export const straight = async (support, wanted) => {
  awaited = null;
  $("caption").textContent = w("computing");
  const { model } = store, before = given_up;
  let answer = await attempt(() => live({ support }, wanted, { whole: true }));
  if (before !== given_up) return null;
  if (answer && model !== store.model) {  // the way of another structure
    note(w("elsewhere", { lost: `${support}: ${wanted.slice(0, 2).join("; ")} m` }));
    answer = null;
  }
  if (answer) moved(answer); else home();
  return answer;
};
const release = async () => {
  const { support, target } = drag, fine = (values) => values.map((value, k) => +value.toFixed(k < 2 ? 4 : 5));
  drag = null;
  if (!fine(target).some(Boolean)) return home();
  root().dataset.settled = "awaited";
  const answer = await straight(support, fine(target));
  if (!answer) return;
  const [x, z, turn] = fine(answer.at);
  const failed = await edit(() => {
    const all = content().settlements ?? [], index = all.findIndex((each) => each.support === support && !each.after);
    const at = ["settlements", index < 0 ? all.length : index];
    return [...(index < 0 ? [[at, { name: freeName("settlements", `${support} `), support }]] : []),
      [[...at, "displacement_m"], [x, z]], ...(index >= 0 || turn ? [[[...at, "rotation_rad"], turn || null]] : [])];
  });
  root().dataset.settled = failed === null ? "written" : "refused";
  if (failed === null) held = { answer, digest: store.state.digest };  // the shape of the file as it is now
  else home();
};

// ---- pointer and keys ----
const down = (event) => {
  const index = event.target.dataset?.block, block = blocks()[index], point = place(event);
  root().setPointerCapture(event.pointerId);
  if (drag) release();
  const box = root().getBoundingClientRect();
  press = { box, x: event.clientX, y: event.clientY, point, index, moved: false, pan: event.button === 1 || store.tool !== "lasso" };
  if (store.tool === "lasso") trail = [point];
  else if (store.tool === "select" && store.step === "settlements" && block?.support && ready()) take(block.support, point);
};
const move = (event) => {
  if (!press) return tip(event);
  press.moved ||= Math.hypot(event.clientX - press.x, event.clientY - press.y) > 4;
  if (!press.moved) return;
  $("tip").hidden = true;
  const point = place(event);
  if (drag) {
    let [dx, dz] = [0, 1].map((i) => (point[i] - drag.from[i]) / times);
    if (event.shiftKey) [dx, dz] = Math.abs(dx) > Math.abs(dz) ? [dx, 0] : [0, dz];
    lead([dx, dz, drag.target[2]]);
  } else if (store.tool === "lasso") { trail.push(point); drawTrail(); }
  else if (press.pan) {
    Object.assign(view, { x: view.x + press.point[0] - point[0], y: view.y - press.point[1] + point[1] });
    root().setAttribute("viewBox", `${view.x} ${view.y} ${view.w} ${view.h}`);
  }
};
const up = (event) => {
  const was = press;
  press = null;
  if (!was) return;
  if (drag && was.moved) release();
  else if (store.tool === "lasso") lassoed();
  else if (!was.moved) { drag = null; click(event, was.index); }
};
const wheel = (event) => {
  event.preventDefault();
  if (drag) lead([drag.target[0], drag.target[1], drag.target[2] - Math.sign(event.deltaY) * 1e-3]);
  else zoom(Math.exp(Math.sign(event.deltaY) * 0.15), place(event));
};
const WAYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const key = (event) => {
  const way = WAYS[event.key], by = event.shiftKey ? 1e-4 : 1e-3;
  if (drag?.keys && way) lead([drag.target[0] + by * way[0], drag.target[1] + by * way[1], drag.target[2]]);
  else if (drag?.keys && event.key === "Enter") release();
  else if (event.key === "Escape") { given_up++; drag = press = null; trail = []; drawTrail(); home(); choose(null); }
  else if (way) walk(way);
  else if (event.key === "Enter" && at !== null) choose(event.altKey ? { blocks: [at] } : { layer: blocks()[at].layer });
  else if (event.key.toLowerCase() === "m" && blocks()[at]?.support) {
    if (ready()) take(blocks()[at].support, null, true);
    $("caption").textContent = ready() ? w("moving", { support: drag.support }) : w("not_yet");
  } else if (event.key === "+" || event.key === "-") zoom(event.key === "+" ? 0.8 : 1.25, middle());
  else if (event.key === "0") fit();
  else return;
  event.preventDefault();
};
const walk = ([wx, wz]) => {
  let best = at ?? 0, least = Infinity;
  if (at !== null) blocks().forEach((block, k) => {
    const [from, to] = [centre(blocks()[at]), centre(block)], [dx, dz] = [to[0] - from[0], to[1] - from[1]];
    const along = dx * wx + dz * wz, off = along + 2 * Math.abs(dx * wz + dz * wx);
    if (k !== at && along > 1e-9 && off < least) [least, best] = [off, k];
  });
  if (!blocks()[best]) return;
  at = best;
  $("caption").textContent = named(at);
  mark();
};
export const begin = () => {
  const on = (name, job, options) => root().addEventListener(name, job, options);
  on("pointerdown", down);
  on("pointermove", move);
  on("pointerup", up);
  on("pointercancel", () => { press = drag = null; home(); });
  on("pointerleave", () => { $("tip").hidden = true; });
  on("wheel", wheel, { passive: false });
  on("keydown", key);
  new ResizeObserver(frame).observe(root());
};
