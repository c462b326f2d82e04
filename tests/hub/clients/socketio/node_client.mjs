// npm's socket.io-client, unchanged, of the generation that is named: events go out as lines of
// JSON, and each line that comes in is [namespace, event, ...arguments] to emit, or ["close"].
import { createInterface } from "node:readline";
import { createRequire } from "node:module";

const [, , modules, name, address, transports, ...namespaces] = process.argv;
const io = createRequire(modules)(name);
const plain = (value) => (Buffer.isBuffer(value) || value instanceof ArrayBuffer ? { bytes: Buffer.from(value).toString("base64") } : value);
const say = (...event) => process.stdout.write(`${JSON.stringify(event)}\n`);

const places = new Map();
const url = new URL(address);
const options = transports === "default" ? {} : { transports: transports.split(",") };
for (const namespace of namespaces) {
  const socket = io(`${url.origin}${namespace}${url.search}`, { ...options, reconnection: false });
  places.set(namespace, socket);
  socket.on("connect", () => say("connect", namespace, null));
  socket.on("disconnect", (reason) => say("disconnect", namespace, reason));
  // Of the old generation and of the new one.
  socket.on("error", (error) => say("connect_error", namespace, error.message ?? String(error)));
  socket.on("connect_error", (error) => say("connect_error", namespace, error.message ?? String(error)));
  for (const event of ["sensedData", "sensedata", "dynamicDB", "server2web", "refused", "list", "metric"]) {
    socket.on(event, (data) => say(event, namespace, plain(data)));
  }
}
for await (const line of createInterface({ input: process.stdin })) {
  const [namespace, event, ...args] = JSON.parse(line);
  if (namespace === "close") break;
  if (namespace === "transport") {
    const engine = places.values().next().value.io.engine;
    say("transport", "", engine.transport.name);
  } else if (args.at(-1) === "answer") {
    places.get(namespace).emit(event, ...args.slice(0, -1), (...answer) => say("answered", namespace, answer[0]));
  } else {
    places.get(namespace).emit(event, ...args);
  }
}
for (const socket of places.values()) socket.disconnect();
// Its last words go out meanwhile.
setTimeout(() => process.exit(0), 200);
