// The steps: which tables of the project file each shows, and what stands in the place of the drawing.
import { $, ask, attempt, content, edit, el, note, number, poll, ready, renderPanel, store, take, w } from "./app.js";
import { add, freeName, straight } from "./drawing.js";
import { chart } from "./charts.js";
import { form, labelOf, parsed, section, supports, tableOf, valueName } from "./form.js";

const TABLES = {  // of the project file, in each step; one that no step names is shown with the drawing
  drawing: ["geometry"], materials: ["material", "contacts", "region"],
  settlements: ["settlements", "tie", "strengthening", "identification", "measurement"], push: ["control", "pushover", "mechanism"],
  earthquake: ["history", "incremental", "campaign"], site: ["assessment", "sensitivity"], results: [], report: ["report"],
};
export const steps = Object.keys(TABLES);
const elsewhere = () => Object.keys(store.schema.properties).filter((name) => name !== "layers" && !Object.values(TABLES).flat().includes(name));
const button = (text, onclick, more = {}) => el("button", { type: "button", onclick, ...more }, text);
const sections = (names, options) => names.filter((name) => store.schema.properties[name]).flatMap((name) => section(name, options?.[name]));

export const dropper = (kind, text, accept) => {
  const input = el("input", { type: "file", hidden: true, multiple: kind === "record", accept, "data-drop": kind, onchange: (event) => take([...event.target.files], kind) });
  const over = (is) => (event) => { event.preventDefault(); event.currentTarget.classList.toggle("over", is); };
  return el("div", { className: "drop", ondragover: over(true), ondragleave: over(false),
    ondrop: (event) => { event.preventDefault(); event.stopPropagation(); take(event.dataTransfer.files, kind); } },
    `${text} `, button(w("choose"), () => input.click()), input);
};

// ---- 0: no project ----
const asked = (id, label, value, more = {}) => el("label", { className: "field" }, el("span", {}, label), el("input", { id, value, "data-at": id, ...more }));
const start = () => {
  const { dropped, state } = store, value = (id) => $(id)?.value ?? "";
  const make = async (given) => { if (await attempt(() => ask("new", given))) { store.dropped = null; await poll(); } };
  const size = (factor) => dropped.size.map((each) => number(each * factor, 3)).join(" × ");
  return [el("h2", {}, w("start")), dropper("drawing", w("drop_drawing"), ".dxf"),
    ...(dropped ? [el("fieldset", { id: "begin" }, el("legend", {}, dropped.name),
      el("p", { className: "note" }, Object.entries(dropped.layers).map(([layer, n]) => `${layer}: ${n}`).join(" · ")),
      asked("new-title", w("title"), dropped.name.replace(/\.dxf$/i, "")),
      el("label", { className: "field" }, el("span", {}, w("unit_of_drawing")), el("select", { id: "new-unit" },
        ...[["mm", 1e-3], ["cm", 1e-2], ["m", 1]].map(([unit, factor]) => el("option", { value: unit, selected: unit === dropped.unit }, `${unit}: ${size(factor)} m`)))),
      asked("new-depth", w("depth"), "", { inputMode: "decimal" }), asked("new-weight", w("unit_weight"), "", { inputMode: "decimal", placeholder: "18" }),
      button(w("make"), () => make({ name: value("new-title"), drawing: dropped.name, title: value("new-title"), unit: value("new-unit"),
        depth_m: parsed(value("new-depth")), unit_weight_kN_m3: parsed(value("new-weight")) }), { className: "main", id: "new-make" }))] : []),
    el("h3", {}, w("templates")), asked("template-name", w("folder_name"), w("my_project")),
    el("p", { className: "row" }, ...Object.entries(store.words[store.language].templates).map(([name, text]) =>
      button(text, () => make({ name: value("template-name"), template: name }), { "data-template": name }))),
    el("h3", {}, w("open")), el("p", { className: "row" }, ...(state.projects ?? []).map((name) => button(name, () => open(name), { "data-open": name }))),
    el("p", { className: "row" }, el("input", { id: "open-folder", placeholder: state.home, "aria-label": w("folder_name") }), button(w("open"), () => open(value("open-folder"))))];
};
const open = async (folder) => { if (await attempt(() => ask("open", { folder }))) await poll(); };

// ---- 1, 2: what is chosen in the drawing, and its layers ----
const FIRST = ["support", "friction", "unit_weight_kN_m3", "vertical_load_kN", "depth_m", "ignore"];
const inherited = (layer) => ({ ...content().material, depth_m: content().geometry?.depth_m, ...(content().layers?.[layer] ?? {}) });
const layerForm = (layer) => form(tableOf("layers"), ["layers", layer], content().layers?.[layer], { first: FIRST, inherited: { ...content().material, depth_m: content().geometry?.depth_m } });
const chosen = () => {
  const { selection, model } = store;
  if (!selection) return [el("p", { className: "note" }, w("choose_help"))];
  if (selection.layer !== undefined) return [el("h2", {}, `${w("layer")} ${selection.layer} · ${w("blocks", { n: model.layers[selection.layer] ?? 0 })}`), ...layerForm(selection.layer)];
  const [first] = selection.blocks, block = model.blocks[first];
  const title = el("h2", {}, selection.blocks.length === 1 ? `${w("block")} ${first} · ${block.layer}` : w("blocks", { n: selection.blocks.length }));
  const outline = selection.outline ?? block.at, index = (content().region ?? []).findIndex((each) => String(each.outline_m) === String(outline));
  if (!store.schema.properties.region) return [title];
  if (index < 0) return [title, el("p", { className: "note" }, w("region_help")),
    button(w("make_region"), () => add("region", { name: freeName("region", `${w("region")} `), outline_m: outline }), { id: "make-region", className: "main" })];
  return [title, ...form(tableOf("region"), ["region", index], content().region[index], { first: ["name", ...FIRST], leave: ["outline_m"], inherited: inherited(block.layer) })];
};
const missingLayers = () => Object.keys(content().layers ?? {}).filter((name) => store.model && !Object.keys(store.model.layers ?? {}).some((each) => each.toLowerCase() === name.toLowerCase()))
  .map((name) => el("p", {}, `${w("not_in_drawing", { name })} `, button(w("remove"), () => edit([[["layers", name], null]]))));
const whole = () => [el("label", { className: "field" }, el("span", {}, w("title")),
  el("input", { "data-at": "title", value: content().title ?? "", onchange: (event) => edit([[["title"], event.target.value]]) })),
  ...form({ ...store.schema, table: "ProjectContent", properties: Object.fromEntries(Object.entries(store.schema.properties).filter(([key]) => ["accuracy", "scatter"].includes(key))) }, [], content())];
const drawingPanel = () => [...chosen(), el("hr"), ...missingLayers(), dropper("drawing", w("other_drawing"), ".dxf"),
  ...whole(), ...sections(["geometry", ...elsewhere().filter((name) => !["title", "accuracy", "scatter"].includes(name))])];
const materialsPanel = () => [...chosen(), el("hr"), ...sections(["material"]), el("h3", {}, labelOf("ProjectContent", "layers")),
  ...Object.keys(store.model?.layers ?? {}).map((layer) => el("details", { "data-at": `layers.${layer}` },
    el("summary", {}, `${layer}${content().layers?.[layer]?.support ? ` · ${w("support")} ${content().layers[layer].support}` : ""}`), ...layerForm(layer))),
  ...sections(["region", "contacts"], { region: { leave: ["outline_m"], first: ["name", ...FIRST] } })];

// ---- 3: movements, ties, what was measured ----
const hypotheses = () => {  // which movements of which supports may explain what was measured: a row each
  const given = content().identification?.hypotheses ?? [];
  const set = (next) => edit([[["identification", "hypotheses"], next.filter((each) => Object.keys(each).length)]]);
  const box = (each, k, support, unknown) => el("label", { className: "check" }, el("input", { type: "checkbox", "data-at": `hypothesis.${k}.${support}.${unknown}`,
    checked: each[support]?.includes(unknown), onchange: (event) => {
      const own = ["x", "z", "rotation"].filter((one) => (one === unknown ? event.target.checked : each[support]?.includes(one)));
      const next = { ...each, [support]: own };
      if (!own.length) delete next[support];
      set(given.length > k ? given.map((other, n) => (n === k ? next : other)) : [...given, next]);
    } }), ` ${valueName(unknown)}`);
  return [...given, {}].map((each, k) => el("fieldset", {}, el("legend", {}, `${w("hypothesis")} ${k + 1}`),
    ...supports().map((support) => el("p", {}, `${support}: `, ...["x", "z", "rotation"].map((unknown) => box(each, k, support, unknown))))));
};
const settlementsPanel = () => [el("p", { className: "note" }, w("settlements_help")),
  ...sections(["settlements"], { settlements: { first: ["name", "support", "displacement_m", "rotation_rad", "to_collapse"], entry: () => ({ name: freeName("settlements", `${w("movement")} `) }),
    extra: (each) => button(w("show_preview"), () => straight(each.support, [...(each.displacement_m ?? [0, 0]), each.rotation_rad ?? 0]), { disabled: !ready() || Boolean(each.after), "data-preview": each.name }) } }),
  ...sections(["tie", "strengthening"]), ...(content().identification ? [] : sections(["identification"], { identification: { entry: () => ({ hypotheses: [{ [supports()[0] ?? ""]: ["x", "z"] }] }) } })),
  ...(content().identification ? [...sections(["identification"], { identification: { leave: ["hypotheses"] } }), ...hypotheses()] : []), ...sections(["measurement"])];

// ---- 5, 6: records and spectra ----
const known = new Map();  // pictures of files and spectra, until the project changes
const fetched = (key, name, given = {}) => {
  if (!known.has(key)) {
    known.set(key, null);
    ask(name, given).then((found) => known.set(key, found), (error) => known.set(key, { error: error.message })).then(() => { wideKey = ""; renderPanel(); });
  }
  return known.get(key);
};
const site = () => (content().assessment ? fetched(`spectrum ${JSON.stringify([content().assessment, store.state.problems])}`, "spectrum") : null);
const spectra = () => Object.entries(site()?.spectra ?? {}).map(([name, each]) => ({ label: `${name} (a_g ${number(each.ag)} g, S ${number(each.S)})`, x: site().periods, y: each.Se }));
const records = () => (content().history ?? []).map((each, k) => [each, k, fetched(`record ${each.record} ${each.time_step_s}`, "record", { name: each.record, time_step: each.time_step_s ?? null })]);
const earthquakeWide = () => {
  const read = records().filter(([, , found]) => found?.time);
  return [dropper("record", w("drop_record"), ".acc,.asc,.at2,.csv,.txt,.dat"),
    ...records().filter(([, , found]) => found?.error).map(([each, , found]) => el("p", { className: "wrong" }, `${each.record}: ${found.error}`)),
    ...(read.length || spectra().length ? [chart(w("spectra"), "T [s]", "S_a [g]", [...spectra().map((each) => ({ ...each, dashed: true })),
      ...read.map(([each, , found]) => ({ label: found.name, x: found.periods, y: found.Sa.map((a) => a * Math.abs(each.scale ?? 1)) }))])] : []),
    ...read.map(([each, k, found]) => {
      const own = each.window_s === "arias" ? found.arias : each.window_s ?? [0, 0];
      return chart(`${found.name} · PGA ${number(found.pga * Math.abs(each.scale ?? 1))} g · ${number(found.time_step)} s · ${number(found.duration)} s${found.unit ? ` · ${found.unit}` : ""} · ${w("window_help")}`, "t [s]", "a [g]",
        [{ label: found.name, x: found.time, y: found.acceleration }], { from: own[0], to: own[1], set: (window) => edit([[["history", k, "window_s"], window]]) });
    })];
};
const siteWide = () => [el("p", { className: "note" }, w("site_help")),
  ...(site()?.error ? [el("p", { className: "wrong" }, site().error)] : []),
  ...(spectra().length ? [chart(w("spectra"), "T [s]", "S_e [g]", spectra())] : [])];
const sitePanel = () => [...sections(["assessment"], { assessment: { first: ["limit_states", "confidence_factor", "site"], entry: () => ({ site: { soil: "B" } }) } }),
  dropper("grid", w("drop_grid"), ".txt,.csv"), ...sections(["sensitivity"])];

// ---- 7: run and results ----
const clock = (seconds) => (seconds === null || seconds === undefined ? "" : seconds < 90 ? `${Math.round(seconds)} s` : `${Math.round(seconds / 60)} min`);
const resultsPanel = () => {
  const { run, results, problems } = store.state, wanted = Object.entries(store.stages).filter(([, table]) => (Array.isArray(content()[table]) ? content()[table].length : content()[table]));
  const only = new Set(store.only ?? []), seconds = results?.timing_s ?? {};
  const choice = ([stage]) => el("label", { className: "field" }, el("input", { type: "checkbox", "data-at": `only.${stage}`, checked: only.has(stage), onchange: (event) => {
    if (event.target.checked) only.add(stage); else only.delete(stage);
    store.only = [...only];
  } }), ` ${valueName(stage)} ${clock(seconds[stage])}`);
  const bar = (stage) => el("div", {}, el("p", {}, `${valueName(stage.stage)}: ${stage.done} / ${stage.total}${stage.taken_over ? ` (${w("taken_over", { n: stage.taken_over })})` : ""}`),
    el("progress", { max: stage.total || 1, value: stage.ended ? stage.total || 1 : stage.done }),
    ...stage.failures.map((each) => el("p", { className: "wrong" }, `✗ ${each.title}: ${each.reasons.join("; ")}`)));
  const state = run.running ? w("running") : run.exit_code === 0 ? w("done") : run.exit_code === 2 ? w("wrong_input") : run.exit_code === null || run.exit_code === undefined ? "" : w("incomplete");
  return [el("h2", {}, w("results")), el("p", { id: "run-state", "data-running": String(run.running), "data-code": run.exit_code ?? "" }, [state, run.under_way, run.seconds_left ? w("left", { time: clock(run.seconds_left) }) : ""].filter(Boolean).join(" · ")),
    ...run.stages.map(bar), ...(run.running ? [] : [el("h3", {}, w("what_is_run")), ...(wanted.length ? wanted.map(choice) : [el("p", { className: "note" }, w("nothing_to_run"))]),
      el("p", { className: "note" }, only.size ? w("only_these") : w("all_of_it")), problems?.length || !ready() ? el("p", { className: "wrong" }, w("not_ready")) : null].filter(Boolean)),
    ...(results ? [results.stale ? el("p", { className: "wrong", id: "stale" }, w("stale")) : el("p", { className: "note", id: "fresh" }, w("fresh"))] : [])];
};
const summary = (rows, governing) => el("table", { id: "summary" }, el("tr", {}, ...["state", "direction", "α0", "d0 [mm]", "ζ_E", "verified"].map((name) => el("th", {}, w(name)))),
  ...rows.map((row) => el("tr", {}, el("td", {}, row.state === "original" ? w("original") : row.state), el("td", {}, (row.direction ?? "").replace("-", "−")), el("td", { className: "number" }, number(row.alpha_0)),
    el("td", { className: "number" }, number(1e3 * row.d_0_m)), el("td", {}, Object.entries(row.checks).map(([name, each]) => `${name} ${number(each.zeta_E)}`).join(" · ")),
    el("td", { className: row.verified === false ? "wrong" : "" }, row.verified === null ? "–" : w(row.verified ? "yes" : "no")))),
  governing ? el("caption", {}, `${w("governing")}: ${governing.state === "original" ? w("original") : governing.state}, ${governing.direction.replace("-", "−")}, ${governing.limit_state}: ζ_E = ${number(governing.zeta_E)}`) : null);
const frame = (at) => el("iframe", { src: `/output/report.html?${store.state.results.stamp}${at}`, title: w("results"), id: "report-frame" });
const resultsWide = () => {
  const { results } = store.state;
  if (!results) return null;
  const found = results.summary;
  return [...(found ? [summary(found.rows, found.governing)] : []),
    ...(results.files.includes("report.html") ? [frame("#viewer")] : [])];
};

// ---- 8: report ----
let written = null;
const reportPanel = () => {
  const { results, run, folder } = store.state;
  if (written?.folder !== folder) { written = { folder, text: null }; attempt(() => ask("judgement")).then((found) => { if (found) { written.text = found.text; renderPanel(); } }); }
  const keep = async (event) => { written.text = event.target.value; delete event.target.dataset.typed; await attempt(() => ask("judgement", { text: written.text })); };
  return [...sections(["report"], { report: { first: ["language", "client", "engineer", "location", "attachments"] } }), dropper("picture", w("drop_picture"), ".png,.jpg,.jpeg"),
    el("h3", {}, w("judgement")), el("p", { className: "note" }, w("judgement_help")),
    el("textarea", { id: "judgement", "data-at": "judgement", value: written.text ?? "", disabled: !results, oninput: (event) => { event.target.dataset.typed = "1"; }, onchange: keep }),
    el("details", { "data-at": "preview" }, el("summary", {}, w("preview_text")), ...marked(written.text ?? "")),
    el("p", { className: "row" }, button(w("print"), async () => { await attempt(() => ask("report")); await poll(); }, { id: "print", disabled: !results || run.running }),
      ...(results?.files ?? []).filter((name) => !name.endsWith(".html")).concat(results ? ["results.json"] : []).map((name) => el("a", { href: `/output/${name}`, target: "_blank", rel: "noopener" }, name)))];
};
const marked = (text) => text.replace(/<!--[\s\S]*?-->/g, "").split("\n").filter((line) => line.trim()).map((line) => {
  const [, sign, rest] = /^(#+|[-*]|)\s*(.*)$/.exec(line);
  return el(sign.startsWith("#") ? "h3" : "p", {}, ...(sign === "-" || sign === "*" ? ["• "] : []), ...rest.split(/\*\*(.+?)\*\*/).map((part, k) => (k % 2 ? el("b", {}, part) : part)));
});

const PANELS = { drawing: drawingPanel, materials: materialsPanel, settlements: settlementsPanel, push: () => sections(TABLES.push, { control: { entry: () => ({ name: freeName("control", "C") }) } }),
  earthquake: () => sections(TABLES.earthquake), site: sitePanel, results: resultsPanel, report: reportPanel };
const reportWide = () => (store.state.results?.files.includes("report.html") ? [frame("")] : null);
const WIDE = { earthquake: earthquakeWide, site: siteWide, results: resultsWide, report: reportWide };
let wideKey = "";
export const panel = () => {
  if (!store.schema) return;
  const { state, step } = store;
  if (!state.folder) { $("panel").replaceChildren(...start()); $("wide").hidden = true; return; }
  const convert = state.source === "project.xlsx" ? [el("p", {}, `${w("spreadsheet")} `, button(w("convert"), async () => { const kept = await attempt(() => ask("convert")); await poll(); if (kept) note(w("kept", kept)); }))] : [];
  $("panel").replaceChildren(...convert, ...(content().geometry ? PANELS[step]() : [el("p", { className: "wrong" }, w("broken"))]));
  if (convert.length) $("panel").querySelectorAll("input, select, textarea, [data-add], [data-remove]").forEach((each) => { each.disabled = true; });
  const made = content().geometry && WIDE[step], key = made ? JSON.stringify([step, store.language, ["results", "report"].includes(step) ? [state.results?.stamp, state.results?.files] : [content().history, content().assessment, [...known.keys()]]]) : step;
  if (key === wideKey) return;
  wideKey = key;
  const parts = made?.();
  $("wide").hidden = !parts;
  $("wide").replaceChildren(...(parts ?? []));
};
