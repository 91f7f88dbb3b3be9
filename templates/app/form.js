// Forms of the tables of the project file, made from its schema: a new key of the file has its field without a line here.
import { content, edit, el, outdated, renderPanel, store, w } from "./app.js";

const FRONT = {  // keys that are asked first, where not the required ones alone
  SiteTable: ["latitude", "longitude", "soil", "topography", "nominal_life_years", "use_class"],
  MaterialTable: ["unit_weight_kN_m3", "friction", "normal_stiffness_kN_m3"],
  PushoverTable: ["contacts", "directions", "increment_m", "control"],
  HistoryTable: ["record", "contacts", "window_s"],
  TieTable: ["name", "from_m", "to_m", "yield_force_kN", "stiffness_kN_m", "states"],
  MeasurementTable: ["name", "kind", "point_m", "opening_mm", "sigma_mm"],
  ContactsTable: ["sliding", "collisions"],
  KnowledgeTable: ["level", "investigations"],
};

// ---- the schema: references followed, "or null" left out ----
const pick = ({ description, default: standard }) =>
  ({ ...(description ? { description } : {}), ...(standard !== undefined ? { default: standard } : {}) });
const plainOf = (schema) => {
  if (schema.$ref) {
    const table = schema.$ref.split("/").pop();
    return { ...store.schema.$defs[table], table, ...pick(schema) };
  }
  const some = schema.anyOf?.filter((each) => each.type !== "null");
  if (some?.length === 1) return { ...plainOf(some[0]), ...pick(schema) };
  return some ? { ...schema, anyOf: some } : schema;
};
const entriesOf = (schema) =>
  Object.values(schema.patternProperties ?? { every: schema.additionalProperties }).find((each) => each?.$ref);
export const tableOf = (name) => {
  const found = plainOf(store.schema.properties[name]), entries = found.items ?? entriesOf(found);
  return entries?.$ref ? plainOf(entries) : found;
};

// ---- words ----
const said = (table, key) => {
  const { keys } = store.words[store.language];
  return keys[`${table}.${key}`] ?? keys[key];
};
const capital = (text) => text[0].toUpperCase() + text.slice(1);
export const labelOf = (table, key) => capital(said(table, key)?.[0] ?? key);
const meaningOf = (table, key, schema) => said(table, key)?.[1] || schema.description || "";
export const valueName = (value) => store.words[store.language].values?.[value] ?? String(value);

// ---- what a name may refer to ----
const named = (table) => (content()[table] ?? []).map((each) => each.name).filter(Boolean);
export const supports = () => {
  const tables = [...Object.values(content().layers ?? {}), ...(content().region ?? [])];
  return [...new Set(tables.map((each) => each.support).filter(Boolean))];
};
const states = () => ["original", ...named("settlements"), ...named("strengthening")];
const layers = () => Object.keys(store.model?.layers ?? {});
const REFERENCES = { "SettlementTable.support": supports, control: () => named("control"), of: states, state: states,
  states, layers, settlements: () => named("settlements"), after: () => named("settlements") };
const referenceOf = (table, key) => REFERENCES[`${table}.${key}`] ?? REFERENCES[key];

// ---- numbers as people write them, lists with semicolons ----
export const parsed = (text) => {
  const plain = text.trim().replace("−", "-").replace(/^([+-]?\d+),(\d+)$/, "$1.$2");
  if (plain === "") return null;
  if (/^(∞|inf)$/i.test(plain)) return "inf";
  return Number.isFinite(Number(plain)) ? Number(plain) : text.trim();
};
const written = (value) => {
  if (value === null || value === undefined) return "";
  if (Array.isArray(value)) return value.map(written).join("; ");
  if (value === "inf") return "∞";
  if (typeof value === "object") return JSON.stringify(value);
  return typeof value === "number" && store.language === "it" ? String(value).replace(".", ",") : String(value);
};
const parts = (text) => text.split(/[;\n]/).map((part) => part.trim()).filter(Boolean);

// ---- one field ----
const commit = async (control, path, value) => {
  const box = control.closest(".field"), sent = [...box.querySelectorAll("[data-typed]")].map((each) => [each, each.value]);
  const error = await edit([[path, value]], true);
  sent.forEach(([each, text]) => { if (each.value === text) delete each.dataset.typed; });  // else there is more to come
  if (outdated()) return renderPanel();  // the field may be of another entry by now
  if (!box.isConnected) return;
  box.classList.toggle("wrong", Boolean(error));
  Object.assign(box.querySelector(".error"), { hidden: !error, textContent: error ?? "" });
};
export const typed = (event) => { event.target.dataset.typed = "1"; };
const input = (at, value, shown, save, more = {}) => el("input", { type: "text", "data-at": at, value, autocomplete: "off",
  placeholder: shown, oninput: typed, onchange: (event) => save(event.target), ...more });

const fieldOf = (table, key, schema, path, given, inherited) => {
  const at = path.join("."), label = labelOf(table, key), known = referenceOf(table, key);
  const save = (control, value) => commit(control, path, value);
  const standard = schema.default === null ? undefined : schema.default;
  const shown = inherited !== undefined ? `${written(inherited)} ←` : written(standard);
  const box = (tag, heading, ...controls) => el(tag, { className: "field", "data-field": at }, el("span", {}, heading),
    ...controls, el("p", { className: "error", hidden: true }),
    el("p", { className: "meaning" }, meaningOf(table, key, schema)));
  const field = (control) => box("label", label, control);

  const choice = (choices, name = valueName) => {
    const none = standard === undefined ? "—" : `(${[standard].flat().map(name).join("; ")})`;
    const chosen = (event) => save(event.target, event.target.value === "" ? null : choices[+event.target.value]);
    return field(el("select", { "data-at": at, onchange: chosen }, el("option", { value: "" }, none),
      ...choices.map((each, k) => el("option", { value: k, selected: each === given }, name(each)))));
  };
  const several = (choices) => {
    const now = new Set(given ?? []);
    const check = (each) => el("label", { className: "check" }, el("input", { type: "checkbox", checked: now.has(each),
      "data-at": `${at}.${each}`, onchange: (event) => {
        now[event.target.checked ? "add" : "delete"](each);
        save(event.target, now.size ? choices.filter((one) => now.has(one)) : null);
      } }), ` ${valueName(each)}`);
    const none = given || standard === undefined ? "" : ` (${[standard].flat().map(valueName).join("; ")})`;
    return box("div", label + none, ...choices.map(check));
  };
  const pair = () => {
    const both = [0, 1].map((i) => input(`${at}.${i}`, written(given?.[i]), standard ? written(standard[i]) : "xz"[i], (control) => {
      const values = both.map((each) => parsed(each.value));
      if (values.every((value) => value === null)) save(control, null);
      else if (values.every((value) => value !== null)) save(control, values);
    }, { inputMode: "decimal", ariaLabel: `${label} ${i + 1}` }));
    return field(el("div", { className: "pair" }, ...both));
  };
  const perKey = (keys) => {  // one name for all, or one for each
    const selects = keys.map((one) => el("select", { "data-at": `${at}.${one}`, ariaLabel: `${label} ${one}`, onchange: (event) => {
      const each = Object.fromEntries(keys.map((of, k) => [of, selects[k].value]).filter(([, name]) => name));
      const names = new Set(Object.values(each));
      save(event.target, !names.size ? null : names.size === 1 && Object.keys(each).length === keys.length ? [...names][0] : each);
    } }, el("option", { value: "" }, `${one}: —`), ...known().map((name) => el("option",
      { value: name, selected: name === (typeof given === "object" ? given[one] : given) }, `${one}: ${name}`))));
    return field(el("div", { className: "pair" }, ...selects));
  };
  const mixed = () => {  // a number or a word, a pair or a word, a name that may be a new one
    const words = (schema.anyOf ?? []).flatMap((each) => each.enum ?? (each.const !== undefined ? [each.const] : []));
    const choices = [...words, ...(known?.() ?? [])], id = `list-${at}`;
    const value = (text) => {
      if (text === "" || choices.includes(text) || schema.type === "string") return text || null;
      return text.includes(";") ? parts(text).map(parsed) : parsed(text);
    };
    return field(el("div", {}, input(at, written(given), shown, (control) => save(control, value(control.value.trim())), { list: id }),
      el("datalist", { id }, ...choices.map((each) => el("option", { value: each })))));
  };
  const asJson = () => field(el("textarea", { "data-at": at, rows: 2, value: written(given), placeholder: shown, oninput: typed,
    onchange: (event) => {
      let value = event.target.value.trim() || null;
      try { value = JSON.parse(value); } catch { /* told by the server */ }
      save(event.target, value);
    } }));

  const values = schema.enum ?? (schema.const !== undefined ? [schema.const] : null), item = schema.items;
  if (values) return choice(values);
  if (schema.type === "boolean") return choice([true, false], (each) => w(each ? "yes" : "no"));
  const keys = known && schema.anyOf?.find((each) => each.propertyNames?.enum)?.propertyNames.enum;
  if (keys) return perKey(keys);
  if (item?.enum) return several(item.enum);
  if (schema.type === "array" && known) return several([...new Set([...known(), ...(given ?? [])])]);
  if (known && !schema.anyOf) return choice([...new Set([...known(), ...(given ? [given] : [])])], String);
  if (schema.prefixItems?.length === 2 && !schema.anyOf) return pair();
  if (["number", "integer"].includes(schema.type)) {
    return field(input(at, written(given), shown, (control) => save(control, parsed(control.value)), { inputMode: "decimal" }));
  }
  if (schema.type === "string") return mixed();
  if (schema.type === "array" && ["string", "number", "integer"].includes(item?.type)) {
    const list = (text) => (item.type === "string" ? parts(text) : parts(text).map(parsed));
    return field(input(at, written(given), shown, (control) => save(control, list(control.value).length ? list(control.value) : null)));
  }
  return schema.anyOf && !schema.anyOf.some((each) => each.type === "object") ? mixed() : asJson();
};

// ---- a table: its fields, those given or asked first, the others folded ----
export const form = (table, path, given = {}, { inherited = {}, first = null, leave = [] } = {}) => {
  const fields = [], folded = [], name = table.table ?? "", all = table.properties;
  const begin = (first ?? FRONT[name] ?? table.required ?? []).filter((key) => all[key]);
  for (const key of new Set([...begin, ...Object.keys(all)])) {
    if (leave.includes(key)) continue;
    const schema = plainOf(all[key]), at = [...path, key];
    const into = begin.includes(key) || given[key] !== undefined ? fields : folded;
    if (schema.properties) into.push(nested(schema, name, key, at, given[key]));
    else if (entriesOf(schema)) into.push(byLayer(schema, name, key, at, given[key] ?? {}));
    else into.push(fieldOf(name, key, schema, at, given[key], inherited[key]));
  }
  if (folded.length < 3 || (!begin.length && folded.length < 7)) return [...fields, ...folded];
  const more = el("summary", {}, w("more_keys", { n: folded.length }));
  return [...fields, el("details", { "data-at": `more.${path.join(".")}` }, more, ...folded)];
};
const nested = (schema, table, key, path, given) => el("fieldset", {}, el("legend", {}, labelOf(table, key)),
  el("p", { className: "note" }, meaningOf(table, key, schema)),
  ...(given === undefined ? [adder(path, schema)] : [...form(schema, path, given), remover(path)]));
const byLayer = (schema, table, key, path, given) => el("fieldset", {}, el("legend", {}, labelOf(table, key)),
  ...layers().map((layer) => el("details", { "data-at": [...path, layer].join(".") }, el("summary", {}, layer),
    ...form(plainOf(entriesOf(schema)), [...path, layer], given[layer]))));
const starter = (schema) => {  // the least that a new table must have; the page asks for the rest
  const value = (key) => {
    const own = plainOf(schema.properties[key]), known = referenceOf(schema.table, key)?.()[0];
    if (own.enum) return own.enum[0];
    if (known) return known;
    if (own.prefixItems) return [0, 0];
    if (own.type === "array") return [];
    return own.type === "string" ? key : Math.max(own.minimum ?? 1, 1);
  };
  return Object.fromEntries((schema.required ?? []).map((key) => [key, value(key)]));
};
const adder = (path, schema, entry = null) => el("button", { type: "button", "data-add": path[0],
  onclick: () => edit([[path, { ...starter(schema), ...entry }]], true) }, `+ ${w("add")}`);
const remover = (path, extra) => el("p", { className: "row" }, extra,
  el("button", { type: "button", "data-remove": path.join("."), onclick: () => edit([[path, null]], true) }, w("remove")));

export const section = (name, options = {}) => {  // [name], or every [[name]], of the file
  const schema = tableOf(name), whole = plainOf(store.schema.properties[name]), given = content()[name];
  const title = [el("h3", {}, labelOf("ProjectContent", name)),
    el("p", { className: "note" }, meaningOf("ProjectContent", name, whole))];
  if (whole.type === "array") {
    const entries = (given ?? []).map((each, k) => el("details", { "data-at": `${name}.${k}`, open: given.length === 1 },
      el("summary", {}, each.name ?? each.record ?? `${k + 1}`), ...form(schema, [name, k], each, options),
      remover([name, k], options.extra?.(each, k))));
    return [...title, ...entries, adder([name, given?.length ?? 0], schema, options.entry?.())];
  }
  const always = (store.schema.required ?? []).includes(name) || Boolean(whole.default);
  if (given === undefined && !always) return [...title, adder([name], schema, options.entry?.())];
  return [...title, ...form(schema, [name], given, options), ...(always ? [] : [remover([name])])];
};
