/** The questions of `talaia init`: tick, rename, units, STOP. Values are read anew each second. */

const byId = (id) => document.getElementById(id);

function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name in element) element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

/** `words` between backticks are what stands in a program. */
function spoken(text) {
  return text.split("`").map((part, index) => (index % 2 === 1 ? make("code", {}, part) : part));
}

const answers = { name: "", unwanted: new Set(), names: {}, units: {}, stop_topic: "", confirmed: new Set() };
const values = new Map();
const pictures = new Map();
let asking = 0;
let asked = null;
let reading = 0;

function tick(path, label, changed) {
  const box = make("input", { type: "checkbox", checked: true, ariaLabel: `Take ${label}` });
  box.addEventListener("change", () => {
    if (box.checked) answers.unwanted.delete(path);
    else answers.unwanted.add(path);
    changed(box.checked);
    showCount();
  });
  return make("label", { className: "tick" }, box);
}

/** A name is one line to who writes it, and as many as it needs to who reads it. */
function keepOneLine(field) {
  const fit = () => {
    // Browsers that do not size a field by its content.
    if (CSS.supports("field-sizing", "content")) return;
    field.style.blockSize = "auto";
    field.style.blockSize = `${String(field.scrollHeight + 2)}px`;
  };
  field.addEventListener("keydown", (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault();
    field.blur();
  });
  field.addEventListener("input", () => {
    if (field.value.includes("\n")) field.value = field.value.replace(/\s*\n\s*/g, " ");
    fit();
  });
  new ResizeObserver(fit).observe(field);
  return field;
}

function nameField(path, name) {
  const field = keepOneLine(make("textarea", { rows: 1, value: name, ariaLabel: `Name of ${name}`, maxLength: 100 }));
  field.addEventListener("change", () => {
    answers.names[path] = field.value.trim();
  });
  return field;
}

function unitField(path, { unit, name }) {
  const field = make("input", { type: "text", value: unit, ariaLabel: `Unit of ${name}`, placeholder: "no unit", maxLength: 30 });
  field.setAttribute("list", "units");
  field.addEventListener("change", () => {
    answers.units[path] = field.value.trim();
  });
  return field;
}

function row(device, part, one) {
  const path = `${device}/${part}/${one.id}`;
  const line = make("div", { className: "row" });
  const value = make("span", { className: "value none" }, part === "signals" ? "…" : part === "streams" ? "no picture yet" : "command");
  if (part === "signals") values.set(one, value);
  const measured = part === "signals" && one.measured;
  // Only numbers have a unit: the others' names have its room.
  if (!measured) line.classList.add("plain");
  line.append(
    tick(path, one.name, (on) => line.classList.toggle("off", !on)),
    nameField(path, one.name),
    ...(measured ? [unitField(path, one)] : []),
    value,
    make("span", { className: "source" }, one.source ?? one.target ?? ""),
  );
  if (part === "streams") {
    const preview = make("img", { className: "preview", alt: `Picture of ${one.name}`, hidden: true });
    preview.addEventListener("load", () => {
      preview.hidden = false;
      value.textContent = "";
    });
    pictures.set(preview, { address: `${device}/${one.id}`, line });
    line.append(preview);
  }
  return line;
}

/** A camera is asked for its next picture while it can be seen; the address is new each time. */
function readPictures() {
  asking += 1;
  for (const [preview, { address, line }] of pictures) {
    if (line.offsetParent !== null) preview.src = `/pictures/${address}?${String(asking)}`;
  }
}

function deviceCard(device) {
  const card = make("section", { className: "card" });
  card.setAttribute("aria-label", device.name);
  const count = [["signals", "value"], ["streams", "camera"], ["commands", "command"]]
    .map(([part, word]) => [device[part].length, word])
    .filter(([many]) => many > 0)
    .map(([many, word]) => `${many} ${word}${many > 1 ? "s" : ""}`)
    .join(", ");
  card.append(
    make("div", { className: "head" }, tick(device.id, device.name, (on) => card.classList.toggle("off", !on)), nameField(device.id, device.name), make("span", { className: "count" }, count)),
  );
  if (device.drive !== "") {
    const line = make("div", { className: "row" });
    line.classList.add("plain");
    line.append(tick(`${device.id}/drive`, `driving of ${device.name}`, (on) => line.classList.toggle("off", !on)), make("span", {}, `Driven by ${device.drive}`));
    card.append(line);
  }
  const first = device.signals.filter(({ primary }) => primary);
  const rest = device.signals.filter(({ primary }) => !primary);
  const more = [
    ...rest.map((one) => ["signals", one]),
    ...device.streams.map((one) => ["streams", one]),
    ...device.commands.map((one) => ["commands", one]),
  ];
  card.append(make("div", { className: "rows" }, ...first.map((one) => row(device.id, "signals", one))));
  if (more.length > 0) {
    card.append(
      make("details", { open: first.length === 0 && more.length <= 8 }, make("summary", {}, first.length > 0 ? `${more.length} more, one click away on its page` : `Show all ${more.length}`), make("div", { className: "rows" }, ...more.map(([part, one]) => row(device.id, part, one)))),
    );
  }
  return card;
}

function choice(name, question, ways, chosen, change) {
  const set = make("fieldset", { className: "question" }, make("legend", {}, ...spoken(question)));
  const line = make("div", { className: "ways" });
  for (const [id, label] of ways) {
    const radio = make("input", { type: "radio", name, value: id, checked: id === chosen });
    radio.addEventListener("change", () => change(id));
    line.append(make("label", {}, radio, label));
  }
  set.append(line);
  return set;
}

function showStop() {
  if (!asked.driven) return;
  byId("stop").hidden = false;
  byId("about-stop").replaceChildren(...spoken(asked.about_stop));
  const at = byId("stop-questions");
  for (const { id, question } of asked.topics) {
    at.append(
      choice(`topic ${id}`, question, [["no", "No, or I do not know"], ["yes", "Yes"]], "no", (way) => {
        if (way === "yes") {
          answers.stop_topic = id;
          // A description has room for one.
          for (const radio of at.querySelectorAll("input[value=no]")) if (radio.name.startsWith("topic ") && radio.name !== `topic ${id}`) radio.checked = true;
        } else if (answers.stop_topic === id) answers.stop_topic = "";
      }),
    );
  }
  for (const { id, question } of asked.signals) {
    at.append(
      choice(`signal ${id}`, question, [["no", "No, or I do not know"], ["yes", "Yes"]], "no", (way) => {
        if (way === "yes") answers.confirmed.add(id);
        else answers.confirmed.delete(id);
      }),
    );
  }
}

function showCount() {
  let signals = 0;
  let devices = 0;
  for (const device of asked.devices) {
    if (answers.unwanted.has(device.id)) continue;
    devices += 1;
    signals += device.signals.filter(({ id }) => !answers.unwanted.has(`${device.id}/signals/${id}`)).length;
  }
  byId("count").textContent = `${devices} devices, ${signals} values → ${asked.output}`;
}

function textOf(signal, newest) {
  const found = signal.channels.map((channel) => newest[channel]);
  if (found.every((value) => value === undefined)) return null;
  return found
    .map((value) => {
      if (value === undefined) return "–";
      if (typeof value === "string") return value;
      if (signal.type === "state") return signal.states[value] ?? String(value);
      if (signal.type === "boolean") return value === 0 ? "no" : "yes";
      return value.toLocaleString(undefined, { maximumFractionDigits: 3 });
    })
    .join(", ");
}

async function readValues() {
  readPictures();
  try {
    const answer = await fetch("/values");
    if (!answer.ok) return;
    const newest = await answer.json();
    for (const [signal, shown] of values) {
      const text = textOf(signal, newest);
      shown.textContent = text ?? "not heard yet";
      shown.title = text ?? "";
      shown.classList.toggle("none", text === null);
    }
  } catch {
    // The program has ended, or is busy: the page says so when something is sent.
  }
}

async function send(event) {
  event.preventDefault();
  const button = document.querySelector("button.main");
  button.disabled = true;
  // The program ends with the answer: a reading under way would be cut off.
  clearInterval(reading);
  const body = JSON.stringify({
    name: answers.name,
    unwanted: [...answers.unwanted],
    names: answers.names,
    units: answers.units,
    stop_topic: answers.stop_topic,
    confirmed_by: [...answers.confirmed],
  });
  const at = byId("problems");
  at.replaceChildren();
  try {
    const answer = await fetch("/answers", { method: "POST", headers: { "content-type": "application/json" }, body });
    if (answer.ok) {
      byId("form").hidden = true;
      byId("lead").hidden = true;
      byId("done-text").textContent = `${asked.output} is there. Next, in the terminal: talaia up ${asked.output}`;
      byId("done").hidden = false;
      byId("done").focus();
      return;
    }
    const problems = answer.status === 422 ? (await answer.json()).problems : [await answer.text()];
    at.append(make("p", {}, "Nothing was written:"), make("ul", {}, ...problems.map((problem) => make("li", {}, problem))));
  } catch {
    at.append(make("p", {}, "talaia init has ended; start it again in the terminal."));
  }
  button.disabled = false;
  reading = setInterval(readValues, 1000);
}

asked = await (await fetch("/questions")).json();
keepOneLine(byId("title")).value = asked.name;
byId("title").addEventListener("change", () => {
  answers.name = byId("title").value.trim();
});
byId("lead").textContent = "This is what was found, with the newest values. Take away what you do not want, and write names as you say them.";
document.body.append(make("datalist", { id: "units" }, ...asked.units.map((unit) => make("option", { value: unit }))));
byId("devices").append(...asked.devices.map(deviceCard));
showStop();
if (asked.left_out.length > 0) {
  const list = byId("left-out");
  list.hidden = false;
  list.querySelector("summary").textContent = `${asked.left_out.length} things are left out, each with the reason`;
  list.querySelector("ul").append(...asked.left_out.map((line) => make("li", {}, line)));
}
byId("form").addEventListener("submit", send);
showCount();
await readValues();
reading = setInterval(readValues, 1000);
