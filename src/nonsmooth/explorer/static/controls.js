// The controls beside the figures: sliders, fields, lists. They show the view, and send gestures.

import { on, send } from "./wire.js";
import { setText } from "./editor.js";

const sliders = document.getElementById("sliders");
const start = document.getElementById("start");
const made = new Map(); // slider and field of each parameter
const starts = new Map();
const shortName = 4; // characters of a state beside whose field another one has room
let typed = {}; // values that are texts
let choices = null; // the last view
let begun = {}; // where the motion begins, with all digits
const asked = new Map(); // field that a gesture came from, by the number of the gesture
let flying = null; // number of the gesture of a slider that is under way
let waiting = null; // the next one
export const timings = []; // milliseconds from a slider's move to the painted portrait

function text(value) {
  return String(Number(Number(value).toPrecision(10)));
}

function flyOut(gesture) {
  if (flying !== null) {
    waiting = gesture;
    return;
  }
  flying = { number: send(gesture), began: gesture.began };
}

// A field whose value is refused is marked until the page shows a view again.
function sendFrom(field, gesture) {
  asked.set(send(gesture), field);
}

function clearMarks(number) {
  for (const field of document.querySelectorAll("input.wrong")) field.classList.remove("wrong");
  for (const earlier of [...asked.keys()]) if (earlier <= number) asked.delete(earlier);
}

// Whether the page waits for what a slider asked for.
export function isMoving() {
  return flying !== null;
}

// A slider waits for the picture of its last place before it asks for the next one. A later gesture,
// or one without a number, stands for it: what it waited for was cancelled.
export function landed(number, painted = true) {
  if (flying === null || (number !== null && number !== undefined && number < flying.number)) return;
  const { began } = flying;
  if (painted) requestAnimationFrame(() => setTimeout(() => timings.push(performance.now() - began), 0));
  flying = null;
  if (waiting) {
    const gesture = waiting;
    waiting = null;
    flyOut(gesture);
  }
}

function makeSlider(slider) {
  const row = document.createElement("div");
  row.className = "slider";
  const id = `p-${slider.name}`;
  const label = document.createElement("label");
  label.className = "name";
  label.htmlFor = id;
  label.title = slider.label;
  const symbol = document.createElement("b");
  symbol.textContent = slider.name;
  label.append(symbol, slider.label);
  const range = Object.assign(document.createElement("input"), { type: "range", id });
  const value = document.createElement("div");
  value.className = "value";
  const field = document.createElement("input");
  field.setAttribute("aria-label", `value of ${slider.name}`);
  field.value = typed[slider.name] ?? text(slider.value);
  const unit = Object.assign(document.createElement("span"), { className: "unit", textContent: slider.unit });
  value.append(field, unit);
  row.append(label, range, value);
  const gesture = (live) => ({
    do: "value", name: slider.name, value: range.value, live, began: performance.now(),
  });
  range.addEventListener("input", () => {
    field.value = range.value;
    flyOut(gesture(true));
  });
  range.addEventListener("change", () => flyOut(gesture(false)));
  field.addEventListener("change", () => {
    sendFrom(field, { do: "value", name: slider.name, value: field.value });
  });
  made.set(slider.name, { row, range, field });
  sliders.append(row);
}

function showValues(message) {
  typed = message.typed;
  for (const [name, { range, field }] of made) {
    if (document.activeElement !== range) range.value = message.values[name];
    if (document.activeElement !== field) field.value = typed[name] ?? text(message.values[name]);
  }
}

function showSliders(sliders_) {
  const names = sliders_.map((slider) => slider.name);
  if (names.join() !== [...made.keys()].join()) {
    sliders.replaceChildren();
    made.clear();
    sliders_.forEach(makeSlider);
  }
  for (const slider of sliders_) {
    const { range } = made.get(slider.name);
    // What it may take does not change while it is moved alone: it keeps a typed value as its end.
    const moved = document.activeElement === range;
    const [low, high] = moved
      ? [Math.min(slider.low, range.min), Math.max(slider.high, range.max)]
      : [slider.low, slider.high];
    Object.assign(range, { min: low, max: high, step: slider.step });
    if (document.activeElement !== range || flying === null) range.value = slider.value;
    range.setAttribute("aria-valuetext", `${text(slider.value)} ${slider.unit}`.trim());
  }
}

function showStart(message) {
  begun = message.start;
  const names = Object.keys(message.start);
  if (names.join() !== [...starts.keys()].join()) {
    start.replaceChildren();
    starts.clear();
    start.classList.toggle("long", names.some((name) => name.length > shortName));
    for (const name of names) {
      const label = document.createElement("label");
      const field = document.createElement("input");
      field.inputMode = "decimal";
      const words = Object.assign(document.createElement("span"), { textContent: name });
      label.title = message.labels?.[name]?.[0] || name;
      label.append(words, field);
      field.addEventListener("change", () => {
        sendFrom(field, { do: "start", states: { ...begun, [name]: field.value } });
      });
      starts.set(name, field);
      start.append(label);
    }
  }
  for (const [name, field] of starts) {
    field.value = text(message.start[name]);
  }
}

function fill(list, names, labels, none) {
  const options = names.map((name) => {
    const option = new Option(name, name);
    option.title = labels[name]?.[0] ?? "";
    return option;
  });
  if (none) options.unshift(new Option("–", ""));
  list.replaceChildren(...options);
}

function fillLists(message) {
  for (const list of document.querySelectorAll("select[data-list]")) {
    const names = list.dataset.list === "plane" ? message.states : message.variables;
    fill(list, names, message.labels, list.dataset.list === "drawn" && list.dataset.place === "1");
  }
  fill(document.querySelector('[data-field="shown"]'), message.diagram_variables, message.labels);
  fill(document.querySelector('[data-field="over"]'), message.parameters, message.labels);
  setText(message.text);
}

// What lists show is of the view always: a choice that is refused goes back.
function showChoices(message) {
  choices = message;
  for (const list of document.querySelectorAll("select[data-field]")) {
    list.value = message.view[list.dataset.field];
  }
  for (const list of document.querySelectorAll("[data-list]")) {
    list.value = message[list.dataset.list][list.dataset.place] ?? "";
  }
}

on("view", (message) => {
  if (message.by_gesture) clearMarks(message.n);
  if (!message.moves && message.n !== null) landed(message.n, false);
  if (message.text !== undefined) fillLists(message);
  if (message.sliders) showSliders(message.sliders);
  showValues(message);
  showStart(message);
  for (const field of document.querySelectorAll("input[data-field]")) {
    if (field !== document.activeElement) field.value = message.view[field.dataset.field];
  }
  showChoices(message);
  for (const field of document.querySelectorAll("[data-between]")) {
    const value = message.between[field.dataset.between];
    if (field !== document.activeElement) field.value = value === undefined ? "" : text(value);
  }
  document.getElementById("unit-of-length").textContent = message.unit_of_length;
  const orbit = document.getElementById("orbit");
  orbit.setAttribute("aria-pressed", String(message.view.turn !== 0));
});

on("piece", (message) => {
  if (message.task === "ranges") showSliders(message.sliders);
});

on("work", (message) => {
  const ended = ["failed", "limit", "stopped"].includes(message.state);
  if (message.task === "motion" && ended) landed(null, false);
});

on("refused", (message) => {
  if (choices) showChoices(choices);
  asked.get(message.n)?.classList.add("wrong");
  landed(message.n, false);
});

for (const field of document.querySelectorAll("[data-field]")) {
  field.addEventListener("change", () => {
    sendFrom(field, { do: "set", fields: { [field.dataset.field]: field.value } });
  });
}
for (const list of document.querySelectorAll("[data-list]")) {
  list.addEventListener("change", () => {
    const all = [...document.querySelectorAll(`[data-list="${list.dataset.list}"]`)];
    const values = all.sort((a, b) => a.dataset.place - b.dataset.place).map((each) => each.value);
    send({ do: "set", fields: { [list.dataset.list]: values.filter(Boolean).join(",") } });
  });
}
for (const field of document.querySelectorAll("[data-between]")) {
  field.addEventListener("change", () => {
    const ends = [...document.querySelectorAll("[data-between]")];
    const values = ends.sort((a, b) => a.dataset.between - b.dataset.between).map((each) => each.value);
    sendFrom(field, { do: "set", fields: { between: values.join(","), height: "" } });
  });
}
document.getElementById("rest").addEventListener("click", () => send({ do: "start", states: {} }));
document.getElementById("all-heights").addEventListener("click", () => {
  send({ do: "set", fields: { height: "" } });
});
document.getElementById("whole-region").addEventListener("click", () => {
  send({ do: "set", fields: { region: "" } });
});

const preset = document.getElementById("preset");
preset.addEventListener("change", () => {
  if (preset.value !== "") send({ do: "preset", number: Number(preset.value) });
});
