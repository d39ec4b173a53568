// The machine in motion, its clock, and the events one by one.

import { on, send } from "./wire.js";
import { isMoving } from "./controls.js";
import { setMarks } from "./plots.js";

const canvas = document.getElementById("machine");
const clock = document.getElementById("clock");
const clockText = document.getElementById("clock-text");
const note = document.getElementById("machine-note");
const play = document.getElementById("play");
const eventText = document.getElementById("event-text");
const seconds = 12; // of the clock on the wall for the whole motion
const pause = 30; // milliseconds at least from one picture of the machine to the next
const lineHeight = 16; // pixels, of texts in the drawing
const calm = window.matchMedia("(prefers-reduced-motion: reduce)").matches;

let drawing = null;
let motion = null;
let marks = { portrait: [], history: [] };
let playing = !calm;
let time = 0;
let last = null;
let size = [0, 0]; // of the canvas in pixels of the page
let chosen = -1;
let asked = 0; // number of the last gesture that chose an event
let wanted = -1; // event of the view, which may be known before the motion is

const short = (value) => Number(value).toPrecision(6).replace(/\.?0+$/, "").replace(/\.?0+e/, "e");

function indexAt(times, t) {
  let low = 0;
  let high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  return t - times[low] <= times[high] - t ? low : high;
}

export function startMark(pane, mark) {
  marks[pane] = mark;
  showTime();
}

function showTime() {
  if (!motion) return;
  const times = motion.time;
  const k = indexAt(times, time);
  const [history, across, up] = motion.curves;
  const event = chosen >= 0 ? motion.events[chosen] : null;
  const [name, x, y] = motion.axes;
  const value = event ? event.at : { [name]: history[k], [x]: across[k], [y]: up[k] };
  setMarks("history", [["rule", time, 0], ["dot", time, value[name]]]);
  setMarks("portrait", [...marks.portrait, ["dot", value[x], value[y]]]);
  const share = (time - times[0]) / (times[times.length - 1] - times[0] || 1);
  clock.value = Math.round(1000 * share);
  clockText.value = `t = ${short(time)}`;
  paint();
}

function paint() {
  const context = canvas.getContext("2d");
  const scale = window.devicePixelRatio || 1;
  const [width, height] = size; // to ask the canvas would lay the page out anew
  if (canvas.width !== width * scale || canvas.height !== height * scale) {
    canvas.width = width * scale;
    canvas.height = height * scale;
  }
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, width, height);
  if (!drawing || !width) return;
  const frame = indexAt(drawing.time, time);
  const [left, right] = drawing.x_range;
  const [low, high] = drawing.y_range;
  const unit = Math.min(width / (right - left), height / (high - low));
  const toX = (x) => width / 2 + (x - (left + right) / 2) * unit;
  const toY = (y) => height / 2 - (y - (low + high) / 2) * unit;
  context.save();
  context.beginPath();
  context.rect(0, 0, width, height);
  context.clip();
  context.lineJoin = "round";
  for (const shape of drawing.shapes) paintShape(context, shape, frame, toX, toY);
  context.restore();
}

function paintShape(context, shape, frame, toX, toY) {
  const visible = shape.visible;
  if (!visible[Math.min(frame, visible.length - 1)]) return;
  const [rows, points] = shape.x.shape;
  const begin = (rows > 1 ? frame : 0) * points;
  if (shape.kind === "text") {
    context.fillStyle = shape.edge;
    context.font = "13px system-ui, 'DejaVu Sans', sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    const lines = shape.text.split("\n"); // a canvas writes a text as one line
    const first = toY(shape.y[begin]) - 0.5 * (lines.length - 1) * lineHeight;
    lines.forEach((line, k) => context.fillText(line, toX(shape.x[begin]), first + k * lineHeight));
    return;
  }
  context.beginPath();
  let drawn = false;
  for (let k = begin; k < begin + points; k += 1) {
    const x = shape.x[k];
    const y = shape.y[k];
    if (Number.isNaN(x) || Number.isNaN(y)) {
      drawn = false;
    } else if (drawn) {
      context.lineTo(toX(x), toY(y));
    } else {
      context.moveTo(toX(x), toY(y));
      drawn = true;
    }
  }
  if (shape.kind === "area") context.closePath();
  if (shape.fill && shape.kind === "area") {
    context.fillStyle = shape.fill;
    context.fill("evenodd");
  }
  if (shape.edge) {
    context.strokeStyle = shape.edge;
    context.lineWidth = 1.4 * shape.width;
    context.setLineDash(shape.dashed ? [5, 4] : []);
    context.stroke();
    context.setLineDash([]);
  }
}

function tick(now) {
  requestAnimationFrame(tick);
  if (last !== null && now - last < pause) return;
  // time stands still under a slider that moves, so that one sees what the slider changes
  if (playing && motion && motion.time.length > 1 && !isMoving()) {
    const times = motion.time;
    const length = times[times.length - 1] - times[0];
    if (last !== null) time += (Math.min(now - last, 100) / 1000 / seconds) * length;
    if (time > times[times.length - 1]) time = times[0];
    chosen = -1;
    showTime();
  }
  last = now;
}

export function setPlaying(on_) {
  playing = on_;
  play.textContent = playing ? "❚❚" : "▶";
  play.setAttribute("aria-pressed", String(playing));
}

export function togglePlay() {
  setPlaying(!playing);
}

function tell(event, k) {
  eventText.replaceChildren();
  const name = document.createElement("b");
  name.textContent = `${event.name.replaceAll("_", " ")} at t = ${short(event.time)}`;
  const count = motion.events.length - 1;
  // the certificate comes first, so that it is seen where the reason is cut
  const number = k ? `${k} of ${count}; ` : "";
  eventText.append(name, ` (${number}${event.certificate}): ${event.reason}`);
  eventText.title = eventText.textContent;
}

export function stepEvent(way, quietly = false) {
  if (!motion?.events.length) return;
  let k = chosen;
  if (k < 0) {
    const later = motion.events.findIndex((event) => event.time > time);
    const next = later < 0 ? motion.events.length : later;
    k = way > 0 ? next - 1 : next;
  }
  goTo(Math.min(motion.events.length - 1, Math.max(0, k + way)), quietly);
}

function goTo(k, quietly) {
  setPlaying(false);
  chosen = k;
  time = motion.events[k].time;
  tell(motion.events[k], k);
  showTime();
  wanted = k;
  if (!quietly) asked = send({ do: "set", fields: { event: String(k) } });
}

on("piece", (message) => {
  if (message.task === "motion") {
    const share = motion ? Number(clock.value) / 1000 : 0;
    motion = message;
    chosen = -1;
    const times = motion.time;
    time = times[0] + share * (times[times.length - 1] - times[0]);
    eventText.textContent = "step from event to event";
    eventText.title = "";
    showTime();
    wantEvent(wanted);
  } else if (message.task === "drawing") {
    drawing = message;
    note.textContent = note.title = drawing.note;
    paint();
  }
});

on("clear", ({ task }) => {
  if (task === "motion") {
    motion = null;
    chosen = -1;
    clockText.value = "";
    eventText.textContent = eventText.title = "";
  } else if (task === "drawing") {
    drawing = null;
    note.textContent = note.title = "";
    paint();
  }
});

// Event of a view; the view after gesture n says nothing of an event that was chosen later.
export function wantEvent(k, n = null) {
  if (n !== null && n < asked) return;
  wanted = k;
  if (motion && k >= 0 && k < motion.events.length && k !== chosen) goTo(k, true);
}

play.addEventListener("click", togglePlay);
document.getElementById("event-before").addEventListener("click", () => stepEvent(-1));
document.getElementById("event-after").addEventListener("click", () => stepEvent(1));
clock.addEventListener("input", () => {
  if (!motion) return;
  setPlaying(false);
  chosen = -1;
  const times = motion.time;
  time = times[0] + (clock.value / 1000) * (times[times.length - 1] - times[0]);
  showTime();
});
new ResizeObserver(([{ contentRect: { width, height } }]) => {
  size = [width, height];
  paint();
}).observe(canvas);
setPlaying(playing);
requestAnimationFrame(tick);
