// The form of a job: fields and sliders for its keys, from what the studio says of them.

const FOLDED = new Set(["design", "sheet"]); // tables that are open at first

/** Fill a form element; `change` is called with a path and a value, null to leave the key out. */
export function fillForm(form, fields, values, change) {
  form.replaceChildren();
  form.onsubmit = (event) => event.preventDefault();
  const tables = new Map();
  for (const field of fields) {
    const name = field.path.length > 1 ? field.path[0] : "job";
    if (!tables.has(name)) tables.set(name, []);
    tables.get(name).push(field);
  }
  const order = [...tables.keys()].sort((a, b) => rank(a) - rank(b));
  for (const name of order) {
    const details = make("details", { open: FOLDED.has(name) });
    details.append(make("summary", { textContent: name[0].toUpperCase() + name.slice(1) }));
    const inner = tables.get(name).map((field) => key(field, valueAt(values, field.path), change));
    details.append(...inner);
    form.append(details);
  }
}

const rank = (name) => ["design", "sheet", "panels", "hinges", "printer"].indexOf(name) >>> 0;

/** Mark the fields whose keys a refusal names. */
export function markFaults(form, text) {
  for (const input of form.querySelectorAll("[data-key]")) {
    const named = text.includes(input.dataset.key);
    input.setAttribute("aria-invalid", named);
  }
}

function valueAt(values, path) {
  return path.reduce((table, name) => table?.[name], values);
}

function make(tag, properties = {}) {
  return Object.assign(document.createElement(tag), properties);
}

function key(field, given, change) {
  const row = make("div", { className: "key" });
  const id = `key-${field.path.join("-")}`;
  const value = given ?? field.default;
  const label = make("label", { htmlFor: id });
  label.append(...field.path.at(-1).split(/(?<=_)/).flatMap((part) => [part, make("wbr")])); // lines end after "_"
  const entry = make("span", { className: "entry" });
  const send = (next) => change(field.path, next);
  const input = INPUTS[field.kind](field, value, send);
  input.id = id;
  input.dataset.key = field.path.join(".");
  entry.append(input, make("span", { className: "unit", textContent: field.unit }));
  row.append(label, entry);
  if (field.kind === "number" || field.kind === "integer") slider(row, field, value, input, send);
  if (field.text) {
    const hint = make("p", { className: "hint", textContent: field.text, id: `${id}-text` });
    input.setAttribute("aria-describedby", hint.id);
    row.append(hint);
  }
  return row;
}

const INPUTS = { number: numberInput, integer: numberInput, boolean, choice, text: textInput };

function numberInput(field, value, send) {
  const input = make("input", { type: "number", step: field.kind === "integer" ? 1 : "any" });
  if (value !== null && value !== undefined) input.value = value;
  input.addEventListener("input", () => {
    if (input.validity.badInput) return;
    send(input.value === "" ? null : Number(input.value));
  });
  return input;
}

/** A slider around the value; other values are typed. */
function slider(row, field, value, input, send) {
  if (typeof value !== "number") return;
  const range = make("input", { type: "range", ...extent(field, value) });
  range.value = value;
  range.setAttribute("aria-label", `${field.path.at(-1)}, slider`);
  range.addEventListener("input", () => {
    input.value = range.value;
    send(Number(range.value));
  });
  input.addEventListener("input", () => (range.value = input.value));
  row.append(range);
}

/** Least and largest place of a slider, and its step. */
export function extent({ kind, unit, low, high }, value) {
  if (kind === "integer") {
    const least = low ?? (value < 0 ? 4 * value : Math.min(1, value));
    return { min: least, max: Math.min(high ?? Infinity, Math.max(3 * Math.abs(value), 12)), step: 1 };
  }
  if (unit === "°") {
    const least = low ?? (value < 0 ? -180 : 0);
    return { min: least, max: Math.min(high ?? Infinity, Math.max(180, value)), step: 0.5 };
  }
  const size = Math.abs(value) || 1;
  const step = 10 ** (Math.floor(Math.log10(size)) - 2);
  const most = Math.min(high ?? Infinity, Math.ceil((3 * size) / step) * step);
  const least = value < 0 ? -3 * size : low > 0 ? Math.max(low, step) : 0;
  return { min: least, max: most, step };
}

function boolean(_, value, send) {
  const input = make("input", { type: "checkbox", checked: value === true });
  input.addEventListener("change", () => send(input.checked));
  return input;
}

function choice(field, value, send) {
  const input = make("select");
  const names = field.default === null ? ["", ...field.choices] : field.choices;
  input.append(...names.map((name) => make("option", { value: name, textContent: name || "(left out)" })));
  input.value = value ?? "";
  input.addEventListener("change", () => send(input.value === "" ? null : input.value));
  return input;
}

function textInput(field, value, send) {
  const input = make("input", { type: "text", autocomplete: "off" });
  input.value = value ?? "";
  if (field.choices.length) {
    const list = make("datalist", { id: `choices-${field.path.join("-")}` });
    list.append(...field.choices.map((name) => make("option", { value: name })));
    input.setAttribute("list", list.id);
    document.getElementById(list.id)?.remove();
    document.body.append(list);
  }
  input.addEventListener("change", () => send(input.value === "" ? null : input.value));
  return input;
}
