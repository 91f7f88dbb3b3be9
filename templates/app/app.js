// The page: what it knows, how it asks, and when it draws what has changed.
import * as drawing from "./drawing.js";
import { forget, historyOf, panel, steps } from "./panels.js";

export const store = { state: {}, model: null, words: null, schema: null, stages: [], language: null,
  step: "drawing", selection: null, tool: "select" };
export const $ = (id) => document.getElementById(id);
export const el = (tag, attributes = {}, ...children) => {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (key in made && key !== "list" && key !== "for") made[key] = value;
    else if (value !== null && value !== undefined) made.setAttribute(key, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined && child !== false));
  return made;
};
export const w = (key, fields = {}) => {
  const text = store.words?.[store.language]?.page?.[key] ?? store.words?.en?.page?.[key] ?? key;
  return text.replace(/\{(\w+)\}/g, (_, name) => fields[name] ?? "");
};
export const number = (value, digits = 3) => {
  if (!Number.isFinite(value)) return value === "inf" ? "∞" : "–";
  const text = String(+value.toPrecision(digits)).replace("-", "−");
  return store.language === "it" ? text.replace(".", ",") : text;
};
export const content = () => store.state.content ?? {};

export class Refused extends Error {
  constructor(status, text) { super(text); this.status = status; }
}

const ANY = new Set(["/state", "/schema", "/open"]);  // asked whatever project is open
const sent = async (path, options) => {
  const project = store.state.project ?? "", own = ANY.has(path) ? {} : { "X-Project": project };
  let answer;
  try {
    answer = await fetch(path, { ...options, headers: { ...options.headers, ...own }, credentials: "same-origin" });
  } catch {
    gone(true);
    throw new Refused(0, w("gone"));
  }
  gone(false);
  const text = await answer.text();
  let data = {};
  try { data = JSON.parse(text); } catch { data = { error: text }; }
  if (!answer.ok) throw new Refused(answer.status, data.error ?? text);
  if (!ANY.has(path) && project !== (store.state.project ?? "")) throw new Refused(409, w("other_opened"));
  return data;
};
export const ask = (name, given = {}) => sent(`/${name}`,
  { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(given) });
export const put = (file, kind, step) => file.size > 50e6
  ? Promise.reject(new Refused(413, w("too_large", { name: file.name })))
  : sent(`/file/${encodeURIComponent(file.name)}?kind=${kind}${step ? `&time_step=${step}` : ""}`, { method: "PUT", body: file });
const putRecord = (file) => put(file, "record").catch(async (error) => {  // one column has no time step of its own
  const step = /time_step_s/.test(error.message) && Number(prompt(w("ask_step", { name: file.name }), "0.005")?.replace(",", "."));
  if (!step) throw error;
  return { ...await put(file, "record", step), step };
});

const gone = (is) => {
  $("gone").hidden = !is;
  if (is) $("gone").textContent = w("gone");
};
let notes = [];
export const note = (text) => {
  if (!text && !notes.length) return;
  notes = text ? [text] : [];
  problems();
};

// ---- changes of the project file: one after the other, each against the version that is known ----
let queue = Promise.resolve();
const inTurn = (job) => (queue = queue.then(job, job));
let formed = new Set();  // digests of the file in which the entries of lists are where the forms have them
export const outdated = () => !formed.has(store.state.digest);
export const forms = () => { formed = new Set([store.state.digest]); };
const shifts = (changes) => changes.some(([path, value]) => value === null && Number.isInteger(path.at(-1)));
// changes: [path, value] each, or a function that makes them when it is their turn; at: their places are those of the forms
export const edit = (changes, at = false) => {
  sending += 1;
  return inTurn(() => written(changes, at)).finally(() => { sending -= 1; setTimeout(later); });
};
const written = async (changes, at) => {
  const { digest, project } = store.state, all = typeof changes === "function" ? changes() : changes;
  $("saved").textContent = w("saving");
  let text = null;
  try {
    if (at && !formed.has(digest)) throw new Refused(409, "");
    const made = await ask("edit", { digest, changes: all });
    if (formed.has(digest) && !shifts(all)) formed.add(made.digest);
  } catch (error) {
    const lost = all.map(([path, value]) => `${path.join(".")} = ${JSON.stringify(value)}`).join("; ");
    text = error.status === 409 ? w(project === store.state.project ? "elsewhere" : "other_opened", { lost }) : error.message;
  }
  await poll().catch(() => {});  // told by gone
  $("saved").textContent = text === null ? w("saved") : "";
  note(text);
  return text;
};
export const step = (name) => inTurn(async () => {
  let text = null;
  try { await ask(name, { digest: store.state.digest }); }
  catch (error) { text = error.status === 409 ? w("elsewhere", { lost: w(name) }) : error.message; }
  await poll().catch(() => {});
  note(text);
});
export const attempt = async (job) => {
  try { const found = await job(); note(""); return found; }
  catch (error) { note(error.status === 409 ? w("other_opened") : error.message); return null; }
};

// ---- what has changed is drawn ----
let seen = "", modelling = false, asked = 0, told = 0;
export const poll = async () => {
  const turn = ++asked, state = await ask("state"), before = store.state;
  if (turn < told) return;  // a later question has its answer already
  told = turn;
  store.state = { ...state, content: state.content ?? (state.folder === before.folder ? before.content : null) };
  if (state.language && (before.folder !== state.folder)) store.language ??= state.language;
  const text = JSON.stringify(state);
  if (text !== seen) {
    seen = text;
    if (before.folder !== state.folder) {
      Object.assign(store, { model: null, selection: null, step: "drawing", tool: "select", only: null, dropped: null });
      forget();
      drawing.show();
    }
    render();
  }
  if (state.folder && state.tag && state.tag !== store.model?.tag) fetchModel(state.tag);
};
const EMPTY = { blocks: [], joints: [], faults: [], warnings: [], layers: {} };
const outlines = (model) => String(model?.blocks.map((block) => block.at));
const fetchModel = async (tag) => {
  if (modelling) return;
  modelling = true;
  const before = store.model, open = store.state.project;
  let found = null;
  try { found = await ask("model"); }
  catch (error) {
    if (![0, 409].includes(error.status)) found = { ...EMPTY, ...before, error: error.message, tag, failed: error.status === 500 };
  }
  modelling = false;
  if (!found || open !== store.state.project) return;  // asked again with the next state
  if (store.model?.tag && store.model.tag === store.state.tag) return;  // by an undo the file is what is shown already
  store.model = found;
  if (outlines(found) !== outlines(before)) store.selection = null;
  drawing.show();
  render();
};
export const choose = (selection) => { store.selection = selection; drawing.mark(); renderPanel(); };

const render = () => {
  const { state } = store, open = Boolean(state.folder);
  document.documentElement.lang = store.language ??= navigator.language?.startsWith("it") ? "it" : "en";
  document.title = open ? `${content().title ?? state.folder} · Assesto` : "Assesto";
  $("title").textContent = open ? content().title ?? state.folder : "";
  const of = `${open} ${store.step} ${store.language}`;
  if ($("steps").dataset.of !== of) {
    $("steps").dataset.of = of;
    $("steps").replaceChildren(...(open ? steps.map((name, k) => el("button", { type: "button", "data-step": name,
      "aria-current": name === store.step ? "step" : null, onclick: () => go(name) }, `${k + 1} ${w(name)}`)) : []));
  }
  for (const name of ["undo", "redo"]) {
    $(name).disabled = !state[name];
    $(name).title = w(name);
    $(name).setAttribute("aria-label", w(name));
  }
  $("run").textContent = `▶ ${w("run")}`;
  $("run").disabled = !ready() || state.run.running;
  $("stop").textContent = `■ ${w("stop")}`;
  $("stop").disabled = !state.run?.running;
  $("actions").querySelectorAll("#undo, #redo, #run, #stop").forEach((each) => { each.hidden = !open; });
  $("language").textContent = store.language === "it" ? "EN" : "IT";
  $("language").title = w("language");
  document.body.dataset.run = state.run?.running ? "running" : "rest";
  document.body.dataset.step = store.step;
  document.body.dataset.digest = state.digest ?? "";
  $("home").title = w("other_project");
  document.body.dataset.open = String(open);
  document.body.dataset.model = store.model?.tag && store.model.tag === state.tag ? "shown" : "awaited";
  drawing.render();
  renderPanel();
  problems();
};
export const ready = () => Boolean(store.state.tag) && !store.state.problems.length
  && store.model?.tag === store.state.tag && !store.model.error;  // what a run would find wrong is known by now
export const go = (name) => { Object.assign(store, { step: name, tool: "select" }); drawing.home(); render(); };

// ---- the panel is drawn again, and not under the hands of who types, chooses or presses in it ----
let waiting = false, held = false, sending = 0;  // sending: changes on their way, without which a field would show what it had
const later = () => { if (waiting) { renderPanel(); problems(); } };
const NAMES = ["data-at", "id", "data-add", "data-remove"];
const placeOf = (control) => {  // a selector that finds it, or what has taken its place
  const folded = control.tagName === "SUMMARY", named = folded ? control.parentElement : control;
  const name = NAMES.find((each) => named.hasAttribute(each));
  return name ? `[${name}="${CSS.escape(named.getAttribute(name))}"]${folded ? " > summary" : ""}` : null;
};
export const renderPanel = () => {
  const at = document.activeElement, box = $("panel"), inside = at !== box && box.contains(at);
  if (held || sending || (inside && (at.dataset.typed || at.dataset.opened))) { waiting = true; return; }
  waiting = false;
  const place = inside ? placeOf(at) : null, top = box.scrollTop, find = (selector) => (selector ? box.querySelector(selector) : null);
  const marked = inside && typeof at.selectionStart === "number" ? [at.selectionStart, at.selectionEnd] : null;
  const whole = marked && marked[0] === 0 && marked[1] === at.value.length;
  const half = outdated() ? [] : [...box.querySelectorAll("[data-typed]")].map((each) => [placeOf(each), each.value]);
  const open = new Set([...box.querySelectorAll("details[open]")].map((each) => each.dataset.at));
  panel();
  box.querySelectorAll("details").forEach((each) => { if (open.has(each.dataset.at)) each.open = true; });
  half.forEach(([selector, value]) => {  // of a pair, what waits for its other half
    const control = find(selector);
    if (control) { control.value = value; control.dataset.typed = "1"; }
  });
  box.scrollTop = top;
  const control = find(place);
  control?.focus({ preventScroll: true });
  if (whole) control?.select?.();
  else if (marked) control?.setSelectionRange?.(...marked);
};
$("panel").addEventListener("focusout", (event) => { delete event.target.dataset.opened; setTimeout(later, 150); });
$("panel").addEventListener("change", (event) => { delete event.target.dataset.opened; });
const pressed = ({ type, target }) => {
  const list = target.closest("select");
  if (list) { list.dataset.opened = "1"; return; }  // a list that is drawn again closes
  if (type === "keydown") return;
  held = true;  // a button that is drawn again, or moves as a meaning folds, is not pressed
  document.activeElement.closest(".field")?.classList.add("told");
};
const released = () => {
  held = false;
  $("panel").querySelectorAll(".told").forEach((each) => each.classList.remove("told"));
  later();
};
for (const part of ["panel", "problems"]) for (const name of ["pointerdown", "keydown"]) $(part).addEventListener(name, pressed);
for (const name of ["pointerup", "pointercancel"]) addEventListener(name, () => setTimeout(released));

const problems = () => {
  if (held) { waiting = true; return; }
  const { state, model } = store, said = [];
  const line = (text, kind, ...more) => said.push(el("p", { className: kind }, text, ...more));
  notes.forEach((text) => line(`✗ ${text}`, "wrong"));
  if (state.error) line(`✗ ${state.error}`, "wrong");
  state.problems?.forEach((text) => line(`✗ ${text}`, "wrong"));
  if (model?.error && !state.problems?.includes(model.error.split("\n")[0])) {
    if (!model.faults?.length) line(`✗ ${model.error}`, "wrong");
    model.faults?.forEach((fault, k) => line(`✗ ${k + 1}: ${fault.text} `, "wrong", fault.points.length
      ? el("button", { type: "button", className: "plain", onclick: () => drawing.look(fault.points[0]) }, w("show")) : ""));
  }
  if (model?.failed) said.push(el("p", {}, el("button", { type: "button", id: "again", onclick: () => { model.tag = null; } }, w("again"))));
  if (model?.repairable) said.push(el("p", {}, `${w("repairable")} `,
    el("button", { type: "button", id: "repair", onclick: repair }, w("see_repair"))));
  model?.warnings?.forEach((text) => line(`⚠ ${text[store.language]}`, ""));
  if (state.run?.said) line(`✗ ${state.run.said}`, "wrong");
  if (!said.length && state.folder && model) line(w("no_problems"), "note");
  $("problems").replaceChildren(...said);
};
const repair = async () => {
  const found = await attempt(() => ask("repair"));
  if (!found) return;
  $("problems").replaceChildren(el("p", {}, w("repair_changes", { n: found.changes.length })),
    ...found.changes.map((text) => el("p", {}, `· ${text}`)),
    el("p", { className: "row" },
      el("button", { type: "button", className: "main", id: "repair-apply", onclick: async () => {
        const made = await attempt(() => ask("repair", { apply: true }));
        if (made?.drawing) await edit([[["geometry", "drawing"], made.drawing]]);
      } }, w("repair_apply")),
      el("button", { type: "button", onclick: problems }, w("cancel"))));
};

// ---- dropped files ----
const KINDS = { dxf: "drawing", png: "picture", jpg: "picture", jpeg: "picture" };
export const take = async (files, kind) => {
  for (const file of files) {
    const suffix = file.name.split(".").pop().toLowerCase();
    const is = kind ?? KINDS[suffix] ?? (store.step === "site" ? "grid" : "record");
    $("saved").textContent = w("reading", { name: file.name });
    const found = await attempt(() => is === "record" ? putRecord(file) : put(file, is));
    $("saved").textContent = "";
    if (!found) continue;
    if (!store.state.folder) { store.dropped = found; renderPanel(); continue; }
    const { name, step } = found;
    await edit({ drawing: [[["geometry", "drawing"], name]], grid: [[["assessment", "site", "grid"], name]],
      picture: () => [[["report", "attachments"], [...new Set([...content().report?.attachments ?? [], name])]]],
      record: () => [[["history", content().history?.length ?? 0], historyOf(name, step)]] }[is]);
  }
};
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => { event.preventDefault(); take(event.dataTransfer.files); });

const then = (job) => attempt(async () => { await job(); await poll(); });
$("home").addEventListener("click", () => then(() => ask("open", { folder: null })));
$("undo").addEventListener("click", () => step("undo"));
$("redo").addEventListener("click", () => step("redo"));
$("run").addEventListener("click", () => {
  go("results");
  then(() => ask("run", store.only?.length ? { only: store.only } : {}));
});
$("stop").addEventListener("click", () => then(() => ask("stop")));
$("language").addEventListener("click", () => {
  store.language = store.language === "it" ? "en" : "it";
  $("saved").textContent = "";
  render();
});
addEventListener("keydown", (event) => {
  if (!(event.ctrlKey || event.metaKey) || /^(INPUT|TEXTAREA)$/.test(document.activeElement.tagName)) return;
  const name = { z: event.shiftKey ? "redo" : "undo", y: "redo" }[event.key.toLowerCase()];
  if (name && !$(name).disabled) { event.preventDefault(); step(name); }
});

const begin = async () => {
  history.replaceState(null, "", "/");  // the token is no longer in the address
  try {
    Object.assign(store, await ask("schema"));
    await poll();
  } catch (error) { $("gone").hidden = false; $("gone").textContent = error.message; }
  const tick = async () => {
    try {
      if (!document.hidden && !store.schema) Object.assign(store, await ask("schema"));
      if (!document.hidden) await poll();
    } catch { /* told by gone */ }
    setTimeout(tick, $("gone").hidden ? 500 : 2000);
  };
  setTimeout(tick, 500);
};
drawing.begin();
begin();
