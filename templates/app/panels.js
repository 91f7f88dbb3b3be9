// The steps: which tables of the project file each shows, and what stands in the place of the drawing.
import { $, ask, attempt, content, edit, el, forms, note, number, poll, ready, renderPanel, store, take, w } from "./app.js";
import { add, freeName, straight } from "./drawing.js";
import { chart } from "./charts.js";
import { form, labelOf, parsed, section, supports, tableOf, typed, valueName } from "./form.js";

const TABLES = {  // of the project file, in each step; one that no step names is shown with the drawing
  drawing: ["geometry"],
  materials: ["material", "contacts", "region"],
  settlements: ["settlements", "tie", "strengthening", "identification", "measurement"],
  push: ["control", "pushover", "mechanism"],
  earthquake: ["history", "incremental", "campaign"],
  site: ["assessment", "sensitivity"],
  results: [],
  report: ["report"],
};
const ROOT = ["title", "accuracy", "scatter"];
export const steps = Object.keys(TABLES);
const elsewhere = () => Object.keys(store.schema.properties)
  .filter((name) => name !== "layers" && ![...ROOT, ...Object.values(TABLES).flat()].includes(name));
const button = (text, onclick, more = {}) => el("button", { type: "button", onclick, ...more }, text);
const small = (text, more = {}) => el("p", { className: "note", ...more }, text);
const wrong = (text, more = {}) => el("p", { className: "wrong", ...more }, text);
const sections = (names, options = {}) =>
  names.filter((name) => store.schema.properties[name]).flatMap((name) => section(name, options[name]));
const dropper = (kind, text, accept) => {
  const input = el("input", { type: "file", hidden: true, multiple: kind === "record", accept, "data-drop": kind,
    onchange: (event) => take([...event.target.files], kind) });
  const over = (is) => (event) => { event.preventDefault(); event.currentTarget.classList.toggle("over", is); };
  const ondrop = (event) => { event.preventDefault(); event.stopPropagation(); take(event.dataTransfer.files, kind); };
  return el("div", { className: "drop", ondragover: over(true), ondragleave: over(false), ondrop },
    `${text} `, button(w("choose"), () => input.click()), input);
};

// ---- 0: no project ----
const asked = (id, label, value, more = {}) =>
  el("label", { className: "field" }, el("span", {}, label), el("input", { id, value, "data-at": id, oninput: typed, ...more }));
const make = (given) => attempt(async () => { await ask("new", given); await poll(); });
const open = (folder) => attempt(async () => { await ask("open", { folder }); await poll(); });
const fromDrawing = (dropped) => {
  const { language } = store, value = (id) => $(id).value, size = (factor) => dropped.size.map((each) => number(each * factor, 3)).join(" × ");
  const units = Object.entries({ mm: 1e-3, cm: 1e-2, m: 1 }).map(([unit, factor]) =>
    el("option", { value: unit, selected: unit === dropped.unit }, `${unit}: ${size(factor)} m`));
  const begin = () => make({ name: value("new-title"), drawing: dropped.name, title: value("new-title"), unit: value("new-unit"),
    depth_m: parsed(value("new-depth")), unit_weight_kN_m3: parsed(value("new-weight")), language });
  return el("fieldset", { id: "begin" }, el("legend", {}, dropped.name),
    small(Object.entries(dropped.layers).map(([layer, n]) => `${layer}: ${n}`).join(" · ")),
    ...(dropped.notes.length ? [small(w("proposed")), el("ul", {}, ...dropped.notes.map((each) => el("li", { className: "note" }, each[language])))] : []),
    asked("new-title", w("title"), dropped.name.replace(/\.dxf$/i, "")),
    el("label", { className: "field" }, el("span", {}, w("unit_of_drawing")), el("select", { id: "new-unit", onchange: typed }, ...units)),
    asked("new-depth", w("depth"), "", { inputMode: "decimal" }),
    asked("new-weight", w("unit_weight"), "", { inputMode: "decimal", placeholder: "18" }),
    button(w("make"), begin, { className: "main", id: "new-make" }));
};
const start = () => {
  const { state, words, language, dropped } = store;
  const templates = Object.entries(words[language].templates).map(([name, text]) =>
    button(text, () => make({ name: $("template-name").value, template: name }), { "data-template": name }));
  const examples = Object.entries(fetched("examples", "examples")?.examples ?? {}).map(([name, title]) =>
    button(words[language].examples?.[name] ?? title, () => make({ name: $("template-name").value, example: name }), { "data-example": name }));
  const folder = el("input", { id: "open-folder", "data-at": "open-folder", placeholder: state.home, ariaLabel: w("folder_name") });
  return [el("h2", {}, w("start")), dropper("drawing", w("drop_drawing"), ".dxf"), ...(dropped ? [fromDrawing(dropped)] : []),
    el("h3", {}, w("templates")), asked("template-name", w("folder_name"), w("my_project")), el("p", { className: "row" }, ...templates),
    el("p", {}, w("examples")), el("p", { className: "row" }, ...examples),
    el("h3", {}, w("open")),
    el("p", { className: "row" }, ...state.projects.map((name) => button(name, () => open(name), { "data-open": name }))),
    el("p", { className: "row" }, folder, button(w("open"), () => open(folder.value)))];
};

// ---- 1, 2: what is chosen in the drawing, and its layers ----
const FIRST = ["support", "friction", "unit_weight_kN_m3", "vertical_load_kN", "depth_m", "ignore"];
const ofAll = () => ({ ...content().material, depth_m: content().geometry.depth_m });
const layerForm = (layer) =>
  form(tableOf("layers"), ["layers", layer], content().layers?.[layer], { first: FIRST, inherited: ofAll() });
const chosen = () => {
  const { selection, model } = store;
  if (!selection) return [small(w("choose_help"))];
  if (selection.layer !== undefined) {
    const count = w("blocks", { n: model.layers[selection.layer] ?? 0 });
    return [el("h2", {}, `${w("layer")} ${selection.layer} · ${count}`), ...layerForm(selection.layer)];
  }
  const [first, ...others] = selection.blocks, { layer, at } = model.blocks[first], outline = selection.outline ?? at;
  const title = el("h2", {}, others.length ? w("blocks", { n: others.length + 1 }) : `${w("block")} ${first} · ${layer}`);
  const regions = content().region ?? [], index = regions.findIndex((each) => String(each.outline_m) === String(outline));
  if (index < 0) {
    const begin = () => add("region", () => ({ name: freeName("region", `${w("region")} `), outline_m: outline }));
    return [title, small(w("region_help")), button(w("make_region"), begin, { id: "make-region", className: "main" })];
  }
  const inherited = { ...ofAll(), ...(content().layers?.[layer] ?? {}) };
  const options = { first: ["name", ...FIRST], leave: ["outline_m"], inherited };
  return [title, ...form(tableOf("region"), ["region", index], regions[index], options)];
};
const missingLayers = () => {
  const drawn = new Set(Object.keys(store.model?.layers ?? {}).map((name) => name.toLowerCase()));
  const gone = ([name, own]) => drawn.size && !own.ignore && !drawn.has(name.toLowerCase());
  return Object.entries(content().layers ?? {}).filter(gone).map(([name]) =>
    el("p", {}, `${w("not_in_drawing", { name })} `, button(w("remove"), () => edit([[["layers", name], null]], true))));
};
const drawingPanel = () => {
  const properties = Object.fromEntries(ROOT.map((key) => [key, store.schema.properties[key]]));
  return [...chosen(), el("hr"), ...missingLayers(), dropper("drawing", w("other_drawing"), ".dxf"),
    ...form({ table: "ProjectContent", properties, required: ["title"] }, [], content()), ...sections(["geometry", ...elsewhere()])];
};
const materialsPanel = () => {
  const title = (layer) => [layer, content().layers?.[layer]?.support].filter(Boolean).join(` · ${w("support")} `);
  const ignored = Object.entries(content().layers ?? {}).filter(([, own]) => own.ignore).map(([layer]) => layer);
  const layers = [...new Set([...Object.keys(store.model?.layers ?? {}), ...ignored])].map((layer) =>
    el("details", { "data-at": `layers.${layer}` }, el("summary", {}, title(layer)), ...layerForm(layer)));
  return [...chosen(), el("hr"), ...sections(["material"]), el("h3", {}, labelOf("ProjectContent", "layers")), ...layers,
    ...sections(["region", "contacts"], { region: { leave: ["outline_m"], first: ["name", ...FIRST] } })];
};

// ---- 3: movements, ties, what was measured ----
const UNKNOWNS = ["x", "z", "rotation"];
const hypotheses = () => {  // which movements of which supports may explain what was measured: a row each
  const given = content().identification.hypotheses ?? [];
  const changed = (k, support, unknown, is) => edit(() => {
    const all = [...content().identification?.hypotheses ?? []], { [support]: had = [], ...others } = all[k] ?? {};
    const own = UNKNOWNS.filter((one) => (one === unknown ? is : had.includes(one)));
    all[k] = { ...others, ...(own.length ? { [support]: own } : {}) };
    return [[["identification", "hypotheses"], all.filter((one) => Object.keys(one).length)]];
  }, true);
  const box = (k, each, support, unknown) => {
    const onchange = (event) => changed(k, support, unknown, event.target.checked);
    const at = `hypothesis.${k}.${support}.${unknown}`;
    return el("label", { className: "check" },
      el("input", { type: "checkbox", checked: Boolean(each[support]?.includes(unknown)), "data-at": at, onchange }), ` ${valueName(unknown)}`);
  };
  return [...given, {}].map((each, k) => el("fieldset", {}, el("legend", {}, `${w("hypothesis")} ${k + 1}`),
    ...supports().map((support) => el("p", {}, `${support}: `, ...UNKNOWNS.map((unknown) => box(k, each, support, unknown))))));
};
const settlementsPanel = () => {
  const show = (each) => button(w("show_preview"),
    () => straight(each.support, [...(each.displacement_m ?? [0, 0]), each.rotation_rad ?? 0]),
    { disabled: !ready() || Boolean(each.after), "data-preview": each.name });
  const settlements = { first: ["name", "support", "displacement_m", "rotation_rad", "to_collapse"], extra: show,
    entry: () => ({ name: freeName("settlements", `${w("movement")} `) }) };
  const identification = { leave: ["hypotheses"], entry: () => ({ hypotheses: [{ [supports()[0] ?? "?"]: ["x", "z"] }] }) };
  return [small(w("settlements_help")), ...sections(["settlements", "tie", "strengthening"], { settlements }),
    ...sections(["identification"], { identification }), ...(content().identification ? hypotheses() : []), ...sections(["measurement"])];
};

// ---- 5, 6: records and spectra ----
let known = new Map();  // pictures of files and spectra of the project, by what they are of
export const forget = () => { known = new Map(); };
const fetched = (key, name, given = {}) => {
  const own = known;
  if (!own.has(key)) {
    own.set(key, null);
    ask(name, given).catch((error) => ({ error: error.message })).then((found) => {
      own.set(key, found);
      wideKey = "";
      renderPanel();
    });
  }
  return known.get(key);
};
const read = (file) => store.state.inputs?.[file];  // what is in a file that a run reads
const site = () => content().assessment
  ? fetched(`spectrum ${JSON.stringify([content().assessment, store.state.problems, read(content().assessment.site?.grid)])}`,
    "spectrum") : null;
const spectra = (dashed) => Object.entries(site()?.spectra ?? {}).map(([name, each]) =>
  ({ label: `${name} (a_g ${number(each.ag)} g, S ${number(each.S)})`, x: site().periods, y: each.Se, dashed }));
const records = () => (content().history ?? []).map((each, k) => {
  const time_step = each.time_step_s ?? null;
  return [each, k, fetched(`record ${each.record} ${time_step} ${read(each.record)}`, "record", { name: each.record, time_step })];
});
const recordChart = ([each, k, found]) => {
  const own = each.window_s === "arias" ? found.arias : each.window_s ?? [0, 0], scale = Math.abs(each.scale ?? 1);
  const times = [found.time_step, found.duration].map((value) => `${number(value)} s`);
  const title = [found.name, `PGA ${number(found.pga * scale)} g`, ...times, found.unit, w("window_help")].join(" · ");
  const range = { from: own[0], to: own[1], set: (ends) => edit([[["history", k, "window_s"], ends]], true) };
  return chart(title, "t [s]", "a [g]", [{ label: found.name, x: found.time, y: found.acceleration }], range);
};
const earthquakeWide = () => {
  const read = records().filter(([, , found]) => found?.time), failed = records().filter(([, , found]) => found?.error);
  const curves = [...spectra(true), ...read.map(([each, , found]) =>
    ({ label: found.name, x: found.periods, y: found.Sa.map((a) => a * Math.abs(each.scale ?? 1)) }))];
  return [dropper("record", w("drop_record"), ".acc,.asc,.at2,.csv,.txt,.dat"),
    ...failed.map(([each, , found]) => wrong(`${each.record}: ${found.error}`)),
    ...(curves.length ? [chart(w("spectra"), "T [s]", "S_a [g]", curves)] : []), ...read.map(recordChart)];
};
const siteWide = () => [small(w("site_help")), ...(site()?.error && !store.state.problems.length ? [wrong(site().error)] : []),
  ...(spectra().length ? [chart(w("spectra"), "T [s]", "S_e [g]", spectra())] : [])];
const elastic = () => content().material?.normal_stiffness_kN_m3 !== undefined;  // else what is added is to be rigid
export const historyOf = (record, step) =>
  ({ record, ...(step ? { time_step_s: step } : {}), ...(elastic() ? {} : { contacts: "rigid" }) });
const ASSESSMENT = { first: ["limit_states", "confidence_factor", "model", "site"],
  entry: () => ({ ...(elastic() ? {} : { model: "none" }), site: { soil: "B" } }) };
const sitePanel = () => [...sections(["assessment"], { assessment: ASSESSMENT }),
  dropper("grid", w("drop_grid"), ".txt,.csv"), ...sections(["sensitivity"])];

// ---- 7: run and results ----
const clock = (seconds) => {
  if (!Number.isFinite(seconds)) return "";
  if (seconds < 90) return `${Math.max(1, Math.round(seconds))} s`;
  return seconds < 5400 ? `${Math.round(seconds / 60)} min` : `${Math.round(seconds / 3600)} h`;
};
const stageBar = (stage) => {
  const over = stage.taken_over ? ` (${w("taken_over", { n: stage.taken_over })})` : "", total = stage.total || 1;
  return el("div", {}, el("p", {}, `${stage.stage.split(": ").map(valueName).join(", ")}: ${stage.done} / ${stage.total}${over}`),
    el("progress", { max: total, value: stage.ended ? total : stage.done }),
    ...stage.failures.map((each) => wrong(`✗ ${each.title}: ${each.reasons.join("; ")}`)));
};
const wanted = () => {  // the stages that the project asks for, to be chosen from, with what they took last time
  const only = new Set(store.only ?? []), took = store.state.results?.timing_s, { expected, elapsed } = store.model ?? {};
  const asks = (stage) => {
    const table = content()[store.stages[stage]];
    return stage === "scenarios" ? table?.some((each) => each.steps) : Array.isArray(table) ? table.length : table;
  };
  const stages = Object.keys(store.stages).filter(asks);
  const choose = (stage) => (event) => {
    only[event.target.checked ? "add" : "delete"](stage);
    store.only = [...only];
  };
  const boxes = stages.map((stage) => {
    const box = { type: "checkbox", "data-at": `only.${stage}`, checked: only.has(stage), onchange: choose(stage) };
    const time = took?.[stage] ? clock(took[stage]) : expected?.[stage] ? `≈ ${clock(expected[stage])}` : "";
    return el("label", { className: "field" }, el("input", box), ` ${valueName(stage)} ${time}`);
  });
  const whole = took || only.size || !elapsed ? [] : [small(w("about", { time: clock(elapsed) }), { id: "about" })];
  return [el("h3", {}, w("what_is_run")), ...(boxes.length ? boxes : [small(w("nothing_to_run"))]),
    small(w(only.size ? "only_these" : "all_of_it")), ...whole, ...(ready() ? [] : [wrong(w("not_ready"))])];
};
const resultsPanel = () => {
  const { run, results } = store.state, ended = { 0: "done", 2: "wrong_input", 3: "incomplete" }[run.exit_code];
  const left = run.seconds_left ? w("left", { time: clock(run.seconds_left) }) : "";
  const state = [run.running ? w("running") : ended ? w(ended) : "", run.under_way, left].filter(Boolean).join(" · ");
  const at = { id: "run-state", "data-running": String(run.running), "data-code": run.exit_code ?? "" };
  return [el("h2", {}, w("results")), el("p", at, state),
    ...run.stages.map(stageBar), ...(run.running ? [] : wanted()),
    ...standing(results)];
};
const standing = (results) => (!results ? [] : [results.stale
  ? wrong({ numbers: w("stale_numbers"), page: w("stale_page") }[results.stale], { id: "stale" }) : small(w("fresh"), { id: "fresh" })]);
const nameOf = (state) => (state === "original" ? w("original") : state);
const summary = ({ rows, governing }) => {
  const way = (direction) => (direction ?? "").replace("-", "−");
  const cells = (row) => [nameOf(row.state), way(row.direction), number(row.alpha_0), number(1e3 * row.d_0_m),
    Object.entries(row.checks).map(([name, each]) => `${name} ${number(each.zeta_E)}`).join(" · "),
    row.verified === null ? "–" : w(row.verified ? "yes" : "no")];
  const head = ["state", "direction", "α0", "d0 [mm]", "borne", "verified"].map((name) => el("th", {}, w(name)));
  const caption = governing && [w("governing"), nameOf(governing.state), way(governing.direction), governing.limit_state,
    `ζ_E = ${number(governing.zeta_E)}`].join(" · ");
  return el("table", { id: "summary" }, caption && el("caption", {}, caption), el("tr", {}, ...head), ...rows.map((row) =>
    el("tr", { className: row.verified === false ? "unverified" : "" }, ...cells(row).map((text) => el("td", {}, text)))));
};
const frame = (at) => {
  const { files, stamp } = store.state.results ?? { files: [] };
  const src = `/output/report.html?project=${store.state.project}&${stamp}${at}`;  // the stamp: after a run it is another page
  return files.includes("report.html") ? [el("iframe", { src, title: w("results"), id: "report-frame" })] : [];
};
const resultsWide = () => {
  const found = store.state.results;
  return found && [...(found.summary?.rows ? [summary(found.summary)] : []), ...frame("#viewer")];
};

// ---- 8: report ----
let opinion = null;
const reportPanel = () => {
  const { results, run, folder } = store.state, stamp = `${folder} ${results?.stamp}`;
  if (opinion?.stamp !== stamp) {
    const own = opinion = { stamp, text: "" };
    attempt(() => ask("judgement")).then((found) => { if (found && own.text === "") { own.text = found.text; renderPanel(); } });
  }
  const keep = async (event) => {
    opinion.text = event.target.value;
    delete event.target.dataset.typed;
    await attempt(() => ask("judgement", { text: opinion.text }));
  };
  const print = () => attempt(async () => { await ask("report"); await poll(); });
  const links = results ? [...results.files.filter((name) => !name.endsWith(".html")), "results.json"] : [];
  return [...sections(["report"], { report: { first: ["language", "client", "engineer", "location", "attachments"] } }),
    dropper("picture", w("drop_picture"), ".png,.jpg,.jpeg"), el("h3", {}, w("judgement")), small(w("judgement_help")),
    el("textarea", { id: "judgement", "data-at": "judgement", value: opinion.text, disabled: !results, onchange: keep,
      oninput: typed }),
    el("details", { "data-at": "preview" }, el("summary", {}, w("preview_text")), ...marked(opinion.text)),
    el("p", { className: "row" }, button(w("print"), print, { id: "print", disabled: !results || run.running }),
      ...links.map((name) => el("a", { href: `/output/${name}?project=${store.state.project}`, download: name }, name))),
    ...standing(results)];
};
const marked = (text) => text.replace(/<!--[\s\S]*?-->/g, "").split("\n").filter((line) => line.trim()).map((line) => {
  const [, sign, rest] = /^(#+|[-*]|)\s*(.*)$/.exec(line), parts = rest.split(/\*\*(.+?)\*\*/);
  return el(sign.startsWith("#") ? "h3" : "p", {}, /[-*]/.test(sign) ? "• " : "",
    ...parts.map((part, k) => (k % 2 ? el("b", {}, part) : part)));
});

// ---- what a step shows ----
const pushPanel = () => sections(TABLES.push, { control: { entry: () => ({ name: freeName("control", "C") }) } });
const PANELS = { drawing: drawingPanel, materials: materialsPanel, settlements: settlementsPanel, push: pushPanel,
  earthquake: () => sections(TABLES.earthquake), site: sitePanel, results: resultsPanel, report: reportPanel };
const WIDE = { earthquake: earthquakeWide, site: siteWide, results: resultsWide, report: () => frame("") };
let wideKey = "";
const spreadsheet = () => el("p", {}, `${w("spreadsheet")} `, button(w("convert"), async () => {
  const kept = await attempt(async () => { const made = await ask("convert"); await poll(); return made; });
  if (kept) note(w("kept", kept));
}));
export const panel = () => {
  const { state, step, schema, language } = store, file = content();
  if (!schema) return;
  forms();
  if (!state.folder) return $("panel").replaceChildren(...start());
  const readOnly = state.source === "project.xlsx";
  $("panel").replaceChildren(...(readOnly ? [spreadsheet()] : []), ...(file.geometry ? PANELS[step]() : [wrong(w("broken"))]));
  if (readOnly) {
    const fields = $("panel").querySelectorAll("input, select, textarea, [data-add], [data-remove]");
    fields.forEach((each) => { each.disabled = true; });
  }
  const results = ["results", "report"].includes(step);
  const of = results ? [state.results?.stamp, state.results?.files] : [file.history, file.assessment, [...known.keys()]];
  const key = JSON.stringify([step, language, state.folder, WIDE[step] ? of : null]);
  if (key === wideKey) return;  // a frame is not loaded again for nothing
  wideKey = key;
  const shown = (file.geometry && WIDE[step]?.()) || [];
  $("wide").hidden = !shown.length;
  $("wide").replaceChildren(...shown);
};
