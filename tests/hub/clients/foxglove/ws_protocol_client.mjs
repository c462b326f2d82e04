// The client of npm's @foxglove/ws-protocol, unchanged: events go out as lines of JSON, and each
// line that comes in is a call of one of its methods: [name, ...arguments]. Bytes go out as text, or in
// another coding that the last argument names, such as "hex".
import { createInterface } from "node:readline";
import { createRequire } from "node:module";

const require = createRequire(process.argv[2]);
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const [, , , address, subprotocol, coding = "utf8"] = process.argv;

const plain = (_key, value) => {
  if (typeof value === "bigint") return value.toString();
  if (ArrayBuffer.isView(value)) return Buffer.from(value.buffer, value.byteOffset, value.byteLength).toString(coding);
  return value;
};
const say = (event, data) => process.stdout.write(`${JSON.stringify([event, data ?? null], plain)}\n`);

const socket = new WebSocket(address, [subprotocol]);
const client = new FoxgloveClient({ ws: socket });
for (const event of [
  "open", "serverInfo", "status", "advertise", "unadvertise", "advertiseServices", "unadvertiseServices",
  "parameterValues", "connectionGraphUpdate", "fetchAssetResponse", "time", "serviceCallResponse", "serviceCallFailure", "message",
]) {
  client.on(event, (data) => say(event, data));
}
client.on("error", (error) => say("error", String(error)));
client.on("close", (event) => {
  say("close", { code: event.code });
  process.exit(0);
});
for await (const line of createInterface({ input: process.stdin })) {
  const [name, ...args] = JSON.parse(line);
  const bytes = args.map((value) =>
    typeof value === "string" && value.startsWith("bytes:") ? new TextEncoder().encode(value.slice(6)) : value,
  );
  const call = bytes.map((value) =>
    value !== null && typeof value === "object" && typeof value.data === "string"
      ? { ...value, data: new DataView(new TextEncoder().encode(value.data).buffer) }
      : value,
  );
  say("returned", client[name](...call) ?? null);
}
