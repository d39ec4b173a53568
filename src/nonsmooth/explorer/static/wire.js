// Messages between the page and its session: JSON in the tags of one model, answers in the tags of
// another. Bokeh carries both. Plain values come as JSON too, and arrays beside them as typed arrays.

let outgoing = null;
export const gestures = { sent: 0, heard: 0 }; // equal where nothing is on its way
const listeners = new Map();

export function on(type, listener) {
  if (!listeners.has(type)) listeners.set(type, []);
  listeners.get(type).push(listener);
}

export function send(gesture) {
  gestures.sent += 1;
  outgoing.tags = [JSON.stringify({ ...gesture, n: gestures.sent })];
  return gestures.sent;
}

export function model(name) {
  return Bokeh.documents[0].get_model_by_name(name);
}

on("heard", (message) => { gestures.heard = message.n; });

function hear(message) {
  for (const listener of listeners.get(message.type) ?? []) listener(message);
}

export function connect(ready) {
  const timer = setInterval(() => {
    const document_ = window.Bokeh?.documents?.[0];
    const incoming = document_?.get_model_by_name("to_page");
    outgoing = document_?.get_model_by_name("from_page");
    if (!incoming || !outgoing) return;
    clearInterval(timer);
    document_.on_event("connection_lost", () => hear({ type: "lost" }));
    incoming.properties.tags.change.connect(() => {
      const { plain, arrays } = incoming.tags[0];
      hear({ ...JSON.parse(plain), ...arrays });
    });
    ready();
  }, 10);
}
