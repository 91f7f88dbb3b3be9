// Forms of the tables of the project file, made from its schema: a new key of the file has its field without a line here.
import { content, edit, el, store, w } from "./app.js";

const UNITS = { m: "m", mm: "mm", kN: "kN", kN_m: "kN/m", kN_m2: "kN/m²", kN_m3: "kN/m³", s: "s", g: "g", rad: "rad", mrad: "mrad", years: "" };
const plainOf = (schema) => {  // references followed, "or null" left out
  if (schema.$ref) return { ...store.schema.$defs[schema.$ref.split("/").pop()], table: schema.$ref.split("/").pop(), ...pick(schema) };
  const some = schema.anyOf?.filter((each) => each.type !== "null");
  if (some?.length === 1) return { ...plainOf(some[0]), ...pick(schema) };
  return some ? { ...schema, anyOf: some } : schema;
};
const pick = ({ description, default: standard }) => ({ ...(description ? { description } : {}), ...(standard !== undefined ? { default: standard } : {}) });
const entriesOf = (schema) => Object.values(schema.patternProperties ?? { every: schema.additionalProperties }).find((each) => each?.$ref);
export const tableOf = (name) => {
  const found = plainOf(store.schema.properties[name]), items = found.items ?? entriesOf(found);
  return items?.$ref ? plainOf(items) : found;
};
const said = (table, key) => {
  const keys = store.words[store.language].keys ?? {};
  return keys[`${table}.${key}`] ?? keys[key];
};
const capital = (text) => text[0].toUpperCase() + text.slice(1);
const unitOf = (key) => Object.keys(UNITS).filter((unit) => key.endsWith(`_${unit}`)).sort((a, b) => b.length - a.length)[0];
export const labelOf = (table, key) => {
  const unit = unitOf(key), name = said(table, key)?.[0] ?? capital((unit ? key.slice(0, -unit.length - 1) : key).replaceAll("_", " "));
  return unit && UNITS[unit] ? `${name} [${UNITS[unit]}]` : name;
};
const meaningOf = (table, key, schema) => said(table, key)?.[1] || schema.description || "";
export const valueName = (value) => store.words[store.language].values?.[value] ?? String(value);

// ---- what a name may refer to ----
const named = (table) => (content()[table] ?? []).map((each) => each.name).filter(Boolean);
export const supports = () => [...new Set(Object.values(content().layers ?? {}).map((each) => each.support)
  .concat((content().region ?? []).map((each) => each.support)).filter(Boolean))];
const states = () => ["original", ...named("settlements"), ...named("strengthening")];
const layers = () => Object.keys(store.model?.layers ?? {});
const REFERENCES = { support: supports, control: () => named("control"), of: states, state: states, states, layers,
  settlements: () => named("settlements"), after: () => named("settlements"), "SettlementTable.support": supports };

// ---- numbers as people write them ----
export const parsed = (text) => {
  const plain = text.trim().replace("−", "-").replace(/^([+-]?\d+),(\d+)$/, "$1.$2");
  if (plain === "") return null;
  if (/^(∞|inf)$/i.test(plain)) return "inf";
  return Number.isFinite(Number(plain)) ? Number(plain) : text.trim();
};
export const written = (value) => value === null || value === undefined ? "" : value === "inf" ? "∞"
  : typeof value === "number" ? (store.language === "it" ? String(value).replace(".", ",") : String(value)) : String(value);
const listed = (value) => Array.isArray(value) ? value.map(written).join("; ") : written(value);
const unlisted = (text) => {
  const parts = text.split(/[;\n]/).map((part) => parsed(part)).filter((part) => part !== null);
  return parts.length ? parts : null;
};

// ---- one field ----
const fieldset = (label, meaning, at, control, pair) => el("label", { className: `field${pair ? " pair" : ""}`, "data-field": at },
  el("span", {}, label), control, el("p", { className: "error", hidden: true }), el("p", { className: "meaning" }, meaning));
const commit = async (control, path, value) => {
  const box = control.closest(".field"), error = await edit([[path, value]]);
  delete control.dataset.typed;
  if (!box?.isConnected) return;
  box.classList.toggle("wrong", Boolean(error));
  const told = box.querySelector(".error");
  told.hidden = !error;
  told.textContent = error ?? "";
};
const input = (at, value, shown, save, more = {}) => el("input", { type: "text", "data-at": at, value: value ?? "", placeholder: shown ?? "",
  autocomplete: "off", oninput: (event) => { event.target.dataset.typed = "1"; }, onchange: (event) => save(event.target), ...more });

const fieldOf = (table, key, schema, path, given, inherited) => {
  const at = path.join("."), label = labelOf(table, key), meaning = meaningOf(table, key, schema), save = (control, value) => commit(control, path, value);
  const shown = inherited !== undefined ? `${listed(inherited)} ←` : schema.default === undefined || schema.default === null ? "" : listed(schema.default);
  const known = REFERENCES[`${table}.${key}`] ?? REFERENCES[key], enumeration = schema.enum ?? (schema.const !== undefined ? [schema.const] : null);
  const set = (control, pair) => fieldset(label, meaning, at, control, pair);
  const choice = (choices, name = valueName) => set(el("select", { "data-at": at, onchange: (event) => save(event.target, event.target.value === "" ? null : choices[+event.target.value]) },
    el("option", { value: "" }, shown ? `(${enumeration ? shown.split("; ").map(valueName).join("; ") : shown})` : "—"),
    ...choices.map((each, k) => el("option", { value: k, selected: each === given }, name(each)))));
  const several = (choices) => {
    const now = new Set(given ?? []), off = (event, each) => {
      if (event.target.checked) now.add(each); else now.delete(each);
      save(event.target, now.size ? choices.filter((one) => now.has(one)) : null);
    };
    return el("div", { className: "field", "data-field": at }, el("span", {}, label + (given ? "" : shown ? ` (${shown.split("; ").map(valueName).join("; ")})` : "")),
      ...choices.map((each) => el("label", { className: "check" }, el("input", { type: "checkbox", "data-at": `${at}.${each}`, checked: now.has(each), onchange: (event) => off(event, each) }), ` ${valueName(each)}`)),
      el("p", { className: "error", hidden: true }), el("p", { className: "meaning" }, meaning));
  };
  if (enumeration) return choice(enumeration);
  if (schema.type === "boolean") return choice([true, false], (each) => w(each ? "yes" : "no"));
  if (schema.type === "array" && schema.items?.enum) return several(schema.items.enum);
  if (schema.type === "array" && known) return several([...new Set([...known(), ...(given ?? [])])]);
  if (known && !schema.anyOf && key !== "support" || known && table === "SettlementTable") return choice([...new Set([...known(), ...(given ? [given] : [])])], String);
  if (schema.prefixItems?.length === 2 && !schema.anyOf) {
    const pair = el("div"), both = [0, 1].map((i) => input(`${at}.${i}`, written(given?.[i]), schema.default ? written(schema.default[i]) : ["x", "z"][i], (control) => {
      const values = both.map((each) => parsed(each.value));
      if (values.every((value) => value === null)) save(control, null);
      else if (values.every((value) => value !== null)) save(control, values);
    }, { inputMode: "decimal", ariaLabel: `${label} ${i + 1}` }));
    pair.append(...both);
    return set(pair, true);
  }
  if (schema.type === "number" || schema.type === "integer") return set(input(at, written(given), shown, (control) => save(control, parsed(control.value)), { inputMode: "decimal" }));
  if (schema.type === "string" && !known) return set(input(at, given, shown, (control) => save(control, control.value.trim() || null)));
  if (schema.type === "array" && ["string", "number", "integer"].includes(schema.items?.type)) return set(el("input", { type: "text", "data-at": at, value: listed(given), placeholder: shown,
    oninput: (event) => { event.target.dataset.typed = "1"; }, onchange: (event) => save(event.target, schema.items.type === "string" ? event.target.value.split(/[;\n]/).map((part) => part.trim()).filter(Boolean) : unlisted(event.target.value)) }));
  if (schema.anyOf && !schema.anyOf.some((each) => each.type === "object") || schema.type === "string") {  // a number or a word, a pair or a word
    const words = (schema.anyOf ?? []).flatMap((each) => each.enum ?? (each.const !== undefined ? [each.const] : [])), id = `list-${at}`;
    const choices = [...words, ...(known?.() ?? [])];
    return fieldset(label, meaning, at, el("div", {}, input(at, listed(given), shown, (control) => {
      const text = control.value.trim(), many = text.includes(";");
      save(control, text === "" ? null : choices.includes(text) || schema.type === "string" ? text : many ? unlisted(text) : parsed(text));
    }, { list: id }), el("datalist", { id }, ...choices.map((each) => el("option", { value: each })))));
  }
  return set(el("textarea", { "data-at": at, rows: 2, value: given === undefined ? "" : JSON.stringify(given), placeholder: shown, oninput: (event) => { event.target.dataset.typed = "1"; },
    onchange: (event) => { let value = event.target.value.trim() || null; try { value = JSON.parse(value); } catch { /* told by the server */ } save(event.target, value); } }));
};

const FRONT = {  // keys that are asked first, where not the required ones alone
  SiteTable: ["latitude", "longitude", "soil", "topography", "nominal_life_years", "use_class"], MaterialTable: ["unit_weight_kN_m3", "friction", "normal_stiffness_kN_m3"],
  PushoverTable: ["contacts", "directions", "increment_m", "control"], HistoryTable: ["record", "contacts", "window_s"], TieTable: ["name", "from_m", "to_m", "yield_force_kN", "stiffness_kN_m", "states"],
  MeasurementTable: ["name", "kind", "point_m", "opening_mm", "sigma_mm"], ContactsTable: ["sliding", "collisions"], KnowledgeTable: ["level", "investigations"],
};

// ---- a table: its fields, those given or required first, the others folded ----
export const form = (table, path, given = {}, { inherited = {}, first = null, leave = [] } = {}) => {
  const fields = [], folded = [], schema = typeof table === "string" ? tableOf(table) : table, name = schema.table ?? "", all = schema.properties;
  const begin = (first ?? FRONT[name] ?? schema.required ?? []).filter((key) => all[key]);
  for (const key of new Set([...begin, ...Object.keys(all)])) {
    if (leave.includes(key)) continue;
    const property = plainOf(all[key]), at = [...path, key], front = begin.includes(key) || given[key] !== undefined;
    if (property.properties) (front ? fields : folded).push(nested(property, name, key, at, given[key]));
    else if (entriesOf(property)) (front ? fields : folded).push(namedTables(property, name, key, at, given[key] ?? {}));
    else (front ? fields : folded).push(fieldOf(name, key, property, at, given[key], inherited[key]));
  }
  return [...fields, folded.length ? el("details", { "data-at": `more.${path.join(".")}` },
    el("summary", {}, w("more_keys", { n: folded.length })), ...folded) : null].filter(Boolean);
};
const nested = (schema, table, key, path, given) => el("fieldset", {}, el("legend", {}, labelOf(table, key)),
  el("p", { className: "note" }, meaningOf(table, key, schema)),
  ...(given === undefined ? [adder(path, schema)] : [...form(schema, path, given), remover(path)]));
const namedTables = (schema, table, key, path, given) => el("fieldset", {}, el("legend", {}, labelOf(table, key)),
  ...layers().map((layer) => el("details", { "data-at": [...path, layer].join(".") }, el("summary", {}, layer),
    ...form(plainOf(entriesOf(schema)), [...path, layer], given[layer]))));
const starter = (schema) => {  // the least that a new table must have; the page asks for the rest
  const made = {};
  for (const key of schema.required ?? []) {
    const property = plainOf(schema.properties[key]), known = REFERENCES[`${schema.table}.${key}`] ?? REFERENCES[key];
    made[key] = property.enum?.[0] ?? (known?.()[0] ?? null) ?? (property.prefixItems ? [0, 0] : property.type === "array" ? [] : property.type === "string" ? key : property.minimum > 1 ? property.minimum : 1);
  }
  return made;
};
const adder = (path, schema, index = null, entry = null) => el("button", { type: "button", "data-add": path.join("."),
  onclick: () => edit([[index === null ? path : [...path, index], { ...starter(schema), ...entry }]]) }, `+ ${w("add")}`);
const remover = (path, extra) => el("p", { className: "row" }, extra, el("button", { type: "button", "data-remove": path.join("."), onclick: () => edit([[path, null]]) }, w("remove")));
export const section = (name, options = {}) => {  // [name], or every [[name]], of the file
  const schema = tableOf(name), whole = plainOf(store.schema.properties[name]), given = content()[name];
  const title = el("h3", {}, labelOf("ProjectContent", name)), meaning = el("p", { className: "note" }, meaningOf("ProjectContent", name, whole));
  if (whole.type === "array") return [title, meaning, ...(given ?? []).map((each, k) => el("details", { "data-at": `${name}.${k}`, open: (given.length === 1 || undefined) },
    el("summary", {}, each.name ?? each.record ?? `${k + 1}`), ...form(schema, [name, k], each, options), remover([name, k], options.extra?.(each, k)))),
    adder([name], schema, given?.length ?? 0, options.entry?.())];
  const always = (store.schema.required ?? []).includes(name) || whole.default !== undefined && whole.default !== null;
  return [title, meaning, ...(given === undefined && !always ? [adder([name], schema, null, options.entry?.())]
    : [...form(schema, [name], given, options), always ? null : remover([name])].filter(Boolean))];
};
