// The editor of the equations: line numbers, and a fault marked in its line with its message.

import { on, send } from "./wire.js";

const text = document.getElementById("text");
const gutter = document.getElementById("gutter");
const marks = document.getElementById("marks");
const fault = document.getElementById("fault");
let shown = "";

function number() {
  const count = text.value.split("\n").length;
  gutter.textContent = Array.from({ length: count }, (_, k) => k + 1).join("\n");
  scroll();
}

function scroll() {
  gutter.scrollTop = text.scrollTop;
  marks.scrollTop = text.scrollTop;
  marks.scrollLeft = text.scrollLeft;
}

function clear() {
  fault.hidden = true;
  marks.replaceChildren();
  text.removeAttribute("aria-invalid");
}

export function setText(value) {
  shown = value;
  text.value = value;
  clear();
  number();
}

function run() {
  send({ do: "text", text: text.value });
}

on("refused", (message) => {
  if (message.of !== "text") return;
  fault.replaceChildren(message.message);
  fault.hidden = false;
  text.setAttribute("aria-invalid", "true");
  marks.replaceChildren();
  if (!message.line) return;
  const lines = text.value.split("\n");
  const row = lines[message.line - 1] ?? "";
  const caret = document.createElement("pre");
  caret.textContent = `${row}\n${" ".repeat(Math.max(0, message.column - 1))}^`;
  fault.prepend(`Line ${message.line}. `);
  fault.append(caret);
  const mark = document.createElement("mark");
  const at = Math.min(message.column - 1, Math.max(0, row.length - 1));
  const word = /^[A-Za-z0-9_.]+/.exec(row.slice(at))?.[0] ?? row.slice(at, at + 1);
  mark.textContent = word || " ";
  const before = [...lines.slice(0, message.line - 1), ""].join("\n") + row.slice(0, at);
  const after = row.slice(at + word.length) + "\n" + lines.slice(message.line).join("\n");
  marks.append(before, mark, after);
  const height = 18;
  text.scrollTop = Math.max(0, (message.line - 4) * height);
  const start = before.length;
  text.setSelectionRange(start, start + word.length);
  text.focus();
  scroll();
});

text.addEventListener("input", () => {
  clear();
  number();
});
text.addEventListener("scroll", scroll);
text.addEventListener("keydown", (event) => {
  if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) {
    event.preventDefault();
    run();
  }
});
document.getElementById("apply").addEventListener("click", run);
document.getElementById("revert").addEventListener("click", () => setText(shown));
