// What lies over Bokeh's figures and moves often: the dot of the present time, where the motion
// starts, the present value in the diagram, and the cross of the keyboard.

import { model, send } from "./wire.js";

const marks = { history: [], portrait: [], diagram: [], plane: [] };
const crosses = {};
const views = {}; // of Bokeh's figures, and what lies over them
const overlays = {};
const step = 0.02; // of the frame, for an arrow key; five times that with Shift
const box = 0.25; // half of a box around the cross

function frame(pane) {
  views[pane] ??= Bokeh.index.find_one(model(pane));
  if (!views[pane]?.frame) return null;
  const { frame: { x_scale: across, y_scale: upward }, model: figure } = views[pane];
  // where the scales put the ends of the ranges, which is no whole number of pixels
  const [left, right] = [figure.x_range.start, figure.x_range.end].map((end) => across.compute(end));
  const [bottom, top] = [figure.y_range.start, figure.y_range.end].map((end) => upward.compute(end));
  return { figure, left, top, width: right - left, height: bottom - top };
}

// Curves, ranges and labels of a motion come one after the other, and the figures paint them once.
const held = new Set();
let holdTimer = 0;
export function hold(panes, longest) {
  for (const pane of panes) {
    if (held.has(pane) || !frame(pane)) continue;
    views[pane].pause();
    held.add(pane);
  }
  clearTimeout(holdTimer);
  holdTimer = setTimeout(release, longest); // a box that is drawn meanwhile is painted too
}

export function release() {
  for (const pane of held) views[pane].unpause();
  held.clear();
}

function place(at, x, y) {
  const { x_range, y_range } = at.figure;
  const right = (x - x_range.start) / (x_range.end - x_range.start);
  const up = (y - y_range.start) / (y_range.end - y_range.start);
  return [right, 1 - up];
}

function overlay(pane) {
  if (!overlays[pane]) {
    overlays[pane] = Object.assign(document.createElement("div"), { className: "overlay" });
    document.querySelector(`[data-pane="${pane}"]`).append(overlays[pane]);
  }
  return overlays[pane];
}

function element(pane, kind) {
  const over = overlay(pane);
  let found = over.querySelector(`.${kind}`);
  if (!found) {
    found = document.createElement("div");
    found.className = kind;
    over.append(found);
  }
  return found;
}

function put(pane, kind, at, right, down) {
  const mark = element(pane, kind);
  const inside = right >= 0 && right <= 1 && (kind === "rule" || (down >= 0 && down <= 1));
  mark.hidden = !inside;
  // a transform moves a mark without a new layout of the page
  const top = kind === "rule" ? at.top : at.top + down * at.height;
  mark.style.transform = `translate(${at.left + right * at.width}px, ${top}px)`;
  if (kind === "rule") mark.style.height = `${at.height}px`;
}

// Marks of a pane: [kind, x, y] in the units of its axes.
export function setMarks(pane, list) {
  marks[pane] = list;
  draw(pane);
}

export function draw(pane) {
  const at = frame(pane);
  if (!at) return;
  const kinds = new Set(marks[pane].filter(([, x]) => x !== null && x !== undefined).map(([kind]) => kind));
  for (const mark of overlay(pane).children) {
    if (!mark.classList.contains("cross") && !kinds.has(mark.className)) mark.hidden = true;
  }
  for (const [kind, x, y] of marks[pane]) {
    if (x === null || x === undefined) continue;
    const [right, down] = place(at, x, y ?? 0);
    put(pane, kind, at, right, down);
  }
  if (crosses[pane]) put(pane, "cross", at, ...crosses[pane]);
}

export function drawAll() {
  for (const pane of Object.keys(marks)) draw(pane);
}

// Ends of ranges come one by one, and the marks move once.
const soon = new Set();
function drawSoon(pane) {
  if (soon.size === 0) {
    requestAnimationFrame(() => {
      const panes = [...soon];
      soon.clear();
      panes.forEach(draw);
    });
  }
  soon.add(pane);
}

function valueAt(at, right, down) {
  const { x_range, y_range } = at.figure;
  return [
    x_range.start + right * (x_range.end - x_range.start),
    y_range.start + (1 - down) * (y_range.end - y_range.start),
  ];
}

export function keys(pane, plot) {
  plot.addEventListener("focus", () => {
    if (pane !== "history") crosses[pane] ??= [0.5, 0.5];
    draw(pane);
    if (crosses[pane]) element(pane, "cross").hidden = false;
  });
  plot.addEventListener("blur", () => {
    if (crosses[pane]) element(pane, "cross").hidden = true;
  });
  if (pane === "history") return;
  plot.addEventListener("keydown", (event) => {
    const at = frame(pane);
    const cross = crosses[pane];
    const by = event.shiftKey ? 5 * step : step;
    const moves = { ArrowLeft: [-by, 0], ArrowRight: [by, 0], ArrowUp: [0, -by], ArrowDown: [0, by] };
    if (moves[event.key]) {
      const held = (value) => Math.min(1, Math.max(0, value));
      crosses[pane] = [held(cross[0] + moves[event.key][0]), held(cross[1] + moves[event.key][1])];
      draw(pane);
    } else if (event.key === "Enter") {
      const [x, y] = valueAt(at, ...cross);
      send({ do: "click", pane, x, y });
    } else if ((event.key === "+" || event.key === "-") && pane !== "portrait") {
      const reach = event.key === "+" ? box : 1.0;
      const [x0, y0] = valueAt(at, cross[0] - reach, cross[1] + reach);
      const [x1, y1] = valueAt(at, cross[0] + reach, cross[1] - reach);
      send({ do: "box", pane, x0, x1, y0, y1 });
      crosses[pane] = [0.5, 0.5];
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  });
}

// A box in the motion is shown larger by Bokeh, and a double click shows all of it again: marks follow.
export function follow() {
  for (const pane of Object.keys(marks)) {
    // the pane is the stop of the Tab key, and not the figure within it
    const inner = Bokeh.index.find_one(model(pane))?.el;
    if (inner) inner.tabIndex = -1;
    const { x_range, y_range } = model(pane);
    for (const range of [x_range, y_range]) range.change.connect(() => drawSoon(pane));
    if (["history", "portrait"].includes(pane)) {
      overlay(pane).parentElement.addEventListener("dblclick", () => [x_range, y_range].forEach((range) => range.reset()));
    }
    new ResizeObserver(() => setTimeout(() => draw(pane), 50)).observe(overlay(pane));
  }
}
