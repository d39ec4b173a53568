// The page: it connects, opens what its link says, and tells what the session says.

import { connect, gestures, on, send } from "./wire.js";
import { isMoving, landed, timings } from "./controls.js";
import { drawAll, follow, hold, keys, release, setMarks } from "./plots.js";
import { startMark, stepEvent, togglePlay, wantEvent } from "./machine.js";

const byId = (id) => document.getElementById(id);
const work = new Map();
const names = {
  motion: "motion", ranges: "sliders", drawing: "drawing", orbit: "orbit", diagram: "diagram", plane: "basins",
  picture: "picture",
};
const patience = 150; // milliseconds in which a motion is there, mostly; then one is told of it
const again = 3000; // milliseconds after which a server that has gone is looked for again
let link = "";
let workTimer = 0;
window.explorer = { gestures, timings, painted: {}, work };

// An address that the visitor has given stays until it is read.
let written = location.hash;
function writeAddress() {
  if (location.hash !== written || location.hash === link) return;
  history.replaceState(null, "", link);
  written = location.hash;
}

// Writes a text where it differs: to write it again would lay the page out anew.
function write(element, text, title = element.title, className = element.className) {
  if (element.textContent !== text) element.textContent = text;
  if (element.title !== title) element.title = title;
  if (element.className !== className) element.className = className;
}

// ------------------------------------------------------------------ tabs

function openTab(name) {
  for (const tab of document.querySelectorAll('[role="tab"]')) {
    const open = tab.id === `tab-${name}`;
    tab.setAttribute("aria-selected", String(open));
    tab.tabIndex = open ? 0 : -1;
    byId(tab.getAttribute("aria-controls")).hidden = !open;
  }
}
for (const tab of document.querySelectorAll('[role="tab"]')) {
  tab.addEventListener("click", () => openTab(tab.getAttribute("aria-controls")));
  tab.addEventListener("keydown", (event) => {
    if (event.key !== "ArrowLeft" && event.key !== "ArrowRight") return;
    const other = tab.id === "tab-parameters" ? "equations" : "parameters";
    openTab(other);
    byId(`tab-${other}`).focus();
  });
}

// ------------------------------------------------------------------ what the session says

on("view", (message) => {
  link = `#${message.link}`;
  if (message.moves) hold(["history", "portrait"], patience);
  if (!isMoving()) writeAddress(); // it takes milliseconds, for which a slider does not wait
  byId("back").disabled = !message.back;
  byId("forward").disabled = !message.forward;
  const [here] = message.marks.diagram;
  setMarks("diagram", [["rule", here, 0]]);
  setMarks("plane", [["start", ...message.marks.plane]]);
  startMark("portrait", [["start", ...message.marks.portrait]]);
  wantEvent(message.view.event, message.n);
  if (message.text !== undefined) {
    const preset = byId("preset");
    const title = message.model.replaceAll("_", " ");
    if (!preset.dataset.kept) preset.value = [...preset.options].find((each) => each.text === title)?.value ?? "";
    delete preset.dataset.kept;
    document.title = `${message.name || "system"}: nonsmooth explorer`;
  }
});

byId("preset").addEventListener("change", () => {
  byId("preset").dataset.kept = "1";
});

on("work", (message) => {
  const { task, state } = message;
  const busy = state === "busy";
  if (busy) work.set(task, "");
  else work.delete(task);
  if (task === "motion" && !busy) requestAnimationFrame(() => setTimeout(writeAddress, 0));
  for (const plot of plotsOf(task)) {
    plot.classList.toggle("stale", busy || state === "stale");
  }
  const note = byId(`${task}-note`);
  if (note) tellNote(note, task, message);
  else if (message.message) toast(message.message);
  showWork();
});

// What stood of another system, or of a task that has nothing to do, is taken away.
on("clear", ({ task }) => {
  const note = byId(`${task}-note`);
  if (note) setNote(note, "");
  const said = byId(`${task}-said`);
  if (said) Object.assign(said, { textContent: "", title: "", className: "said" });
  if (task === "motion") chips("modes", []);
  if (task === "plane") {
    chips("basins", []);
    byId("basins").title = "";
  }
  if (task === "motion") for (const pane of ["history", "portrait"]) setMarks(pane, []);
});

// A note lies over its picture, so it can be put away; it comes again with other words.
function setNote(note, words) {
  if (note.dataset.words === words) return;
  note.dataset.words = words;
  note.replaceChildren();
  if (!words) return;
  const away = document.createElement("button");
  Object.assign(away, { className: "away", title: "Hide this note" });
  away.setAttribute("aria-label", "Hide this note");
  away.addEventListener("click", () => note.replaceChildren());
  note.append(away, words);
}

function tellNote(note, task, message) {
  if (message.state === "done" && !message.message) return; // a note of the pieces stays
  setNote(note, message.message ?? "");
  if (message.go_on) {
    const more = Object.assign(document.createElement("button"), { className: "link", textContent: message.go_on });
    more.addEventListener("click", () => send({ do: "go on", task }));
    note.append(" ", more); // after the words, and beside the button that hides them
  }
}

function plotsOf(task) {
  const panes = { motion: ["history", "portrait"], diagram: ["diagram"], plane: ["plane"] }[task] ?? [];
  return panes.map((pane) => document.querySelector(`[data-pane="${pane}"]`));
}

function showWork() {
  const long = [...work].filter(([task]) => task !== "motion");
  byId("work").classList.toggle("busy", work.size > 0);
  byId("stop").hidden = long.length === 0;
  const said = long.map(([task, how]) => (how ? `${names[task]}: ${how}` : names[task]));
  const words = said.length ? said.join(", ") : work.size ? "" : "ready";
  clearTimeout(workTimer);
  workTimer = setTimeout(() => write(byId("work-text"), words, words), words ? 0 : patience);
}

on("piece", (message) => {
  const { task } = message;
  window.explorer.painted[task] = (window.explorer.painted[task] ?? 0) + 1;
  if (work.has(task)) work.set(task, message.said ?? "");
  for (const plot of plotsOf(task)) plot.classList.remove("stale");
  if (message.remark !== undefined) setNote(byId(`${task}-note`), message.remark);
  if (task === "motion") {
    release();
    landed(message.n);
    chips("modes", message.modes);
    const more = `${message.said}\n${message.title}\nmodes of the last period: ${message.word}`;
    write(byId("motion-said"), message.said, more, `said ${message.fine ? "fine" : "doubt"}`);
  } else if (task === "orbit") {
    tellOrbit(message);
  } else if (task === "diagram" || task === "plane") {
    Object.assign(byId(`${task}-said`), { textContent: message.said, title: message.title ?? "" });
    if (task === "plane" && message.chips.length) {
      chips("basins", message.chips);
      byId("plane-said").textContent = ""; // the number of starts gives its room to the shares
      byId("basins").title = [message.title, ...message.chips.map(([text]) => text)].join("\n");
    } else if (task === "plane") chips("basins", []);
  }
  requestAnimationFrame(drawAll);
  showWork();
});

const shownChips = {};
function chips(id, entries) {
  const told = JSON.stringify(entries);
  if (shownChips[id] === told) return;
  shownChips[id] = told;
  byId(id).replaceChildren(
    ...entries.map(([name, colour]) => {
      const chip = Object.assign(document.createElement("span"), { className: "chip" });
      const patch = document.createElement("i");
      patch.style.background = colour;
      chip.append(patch, name);
      return chip;
    }),
  );
}

function tellOrbit(message) {
  const place = byId("orbit-text");
  if (message.branch) {
    const said = Object.assign(document.createElement("p"), { className: "quiet" });
    said.textContent = message.branch.length ? `Branch: ${message.branch.join("; ")}.` : "";
    place.append(said);
    return;
  }
  const title = document.createElement("h3");
  if (!message.found) {
    title.textContent = "No orbit was found";
    place.replaceChildren(title, message.message);
    return;
  }
  title.textContent = message.title;
  const table = document.createElement("table");
  const row = (name, value) => {
    const line = table.insertRow();
    line.insertCell().textContent = name;
    line.insertCell().textContent = value;
  };
  message.multipliers.forEach(([value, size], k) => {
    row(k === 0 ? "multipliers" : "", value);
    if (k === 0 && size > 1) table.rows[0].cells[1].style.color = "var(--vermilion)";
  });
  row("length", Number(message.length.toPrecision(9)));
  row("residual", message.residual.toExponential(1));
  const words = Object.assign(document.createElement("p"), { className: "quiet" });
  words.textContent = message.admissible ? message.word : message.message;
  place.replaceChildren(title, table, words);
}

on("view", (message) => {
  if (message.view.turn === 0 && !byId("orbit-text").querySelector(".quiet:only-child")) {
    const said = Object.assign(document.createElement("p"), { className: "quiet" });
    said.textContent =
      "Press Orbit for the periodic orbit near the end of the motion, with its multipliers," +
      " and its branch in the diagram.";
    byId("orbit-text").replaceChildren(said);
  }
});

// ------------------------------------------------------------------ messages

let toastTimer = 0;
function toast(text) {
  const place = byId("toast");
  place.textContent = text;
  place.hidden = false;
  clearTimeout(toastTimer);
  toastTimer = setTimeout(() => { place.hidden = true; }, 8000);
}

// Without the server nothing is computed. What is shown stays, and the address says what it is.
on("lost", () => {
  work.clear();
  byId("work").classList.remove("busy");
  byId("stop").hidden = true;
  clearTimeout(workTimer);
  write(byId("work-text"), "not connected");
  toast(
    "The server of this page has ended, or cannot be reached: nothing is computed any more. Start it again at this" +
      " address, or copy the link, and open it on another server.",
  );
  clearTimeout(toastTimer);
  // another server knows nothing of this page: a new page shows what the address says
  setInterval(async () => {
    const answer = await fetch(location.pathname, { cache: "no-store" }).catch(() => null);
    if (answer?.ok) location.reload();
  }, again);
});

on("refused", (message) => {
  if (message.of !== "text") toast(message.message);
});
on("view", (message) => {
  if (message.by_gesture) byId("toast").hidden = true; // what was wrong has been put right
});

// ------------------------------------------------------------------ copies and pictures

const dialog = byId("copied");
async function offer(title, text) {
  byId("copied-title").textContent = title;
  byId("copied-text").value = text;
  byId("copied-said").textContent = "";
  dialog.showModal();
  await copy(text);
}
async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    byId("copied-said").textContent = "It is in the clipboard.";
  } catch {
    byId("copied-text").select();
    byId("copied-said").textContent = "Press Ctrl+C to copy it.";
  }
}
const titles = { python: "Script of Python", command: "Commands of the shell", toml: "System as TOML" };
on("copy", (message) => offer(titles[message.as], message.text));
byId("copied-again").addEventListener("click", () => copy(byId("copied-text").value));
byId("copied-close").addEventListener("click", () => dialog.close());
for (const button of document.querySelectorAll("[data-copy]")) {
  button.addEventListener("click", () => {
    const kind = button.dataset.copy;
    if (kind === "link") offer("Link to this view", new URL(link, location.href).href);
    else send({ do: "copy", as: kind });
  });
}

for (const place of document.querySelectorAll("[data-print]")) {
  const list = document.createElement("select");
  list.setAttribute("aria-label", `print the ${place.dataset.print}`);
  list.title = "A picture for print";
  list.append(new Option("⤓", ""), ...[".pdf", ".svg", ".png"].map((each) => new Option(each.slice(1).toUpperCase(), each)));
  list.addEventListener("change", () => {
    send({ do: "print", pane: place.dataset.print, suffix: list.value });
    list.value = "";
  });
  place.append(list);
}
on("file", (message) => {
  const bytes = Uint8Array.from(atob(message.data), (letter) => letter.charCodeAt(0));
  const anchor = document.createElement("a");
  anchor.href = URL.createObjectURL(new Blob([bytes]));
  anchor.download = message.name;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(anchor.href), 10_000);
});

// ------------------------------------------------------------------ buttons and keys

byId("back").addEventListener("click", () => send({ do: "back" }));
byId("forward").addEventListener("click", () => send({ do: "forward" }));
byId("stop").addEventListener("click", () => send({ do: "stop" }));
byId("orbit").addEventListener("click", () => send({ do: "orbit" }));
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || dialog.open) return;
  if (event.key === "Escape") send({ do: "stop" });
  if (event.target.closest("input, textarea, select")) return;
  if (event.key === " " && event.target.closest("button")) return;
  const actions = {
    "[": () => stepEvent(-1), "]": () => stepEvent(1), " ": togglePlay,
    o: () => send({ do: "orbit" }), Backspace: () => send({ do: "back" }),
  };
  if (!actions[event.key]) return;
  event.preventDefault();
  actions[event.key]();
});

// A link that is pasted into the same page, and the buttons of the browser.
window.addEventListener("hashchange", () => {
  written = location.hash;
  if (location.hash !== link) send({ do: "link", link: location.hash });
});

connect(() => {
  for (const plot of document.querySelectorAll(".plot")) keys(plot.dataset.pane, plot);
  follow();
  if (location.hash.length > 1) send({ do: "link", link: location.hash, first: true });
  else send({ do: "hello" });
});
