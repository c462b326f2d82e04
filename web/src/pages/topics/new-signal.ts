/** From a field of a raw topic to a signal of the site's description. Pure. */

import { addressWord, changedAt, freeName, isObject, keyLabel, valueAt, type Json, type JsonObject } from "../description/json-schema.js";

/** A field of a topic, as somebody who looks at a message points at it. */
export interface TopicField {
  readonly topic: string;
  /** Of its messages: `package/msg/Name`. */
  readonly type: string;
  /** As descriptions write it: `pose.position.x`, `shelves[1].celsius`. */
  readonly field: string;
  /** It holds words, no number. */
  readonly text: boolean;
}

/** What a person says of the signal to be. */
export interface SignalWords {
  readonly device: string;
  readonly name: string;
  readonly unit: string;
}

/** Fields that say nothing by their own name. */
const NAMELESS = new Set(["data", "value", "x", "y", "z", "w"]);

/** The devices of a description that a signal can be added to: their words and names. */
export function devicesOf(described: JsonObject): (readonly [id: string, name: string])[] {
  const devices = valueAt(described, ["devices"]);
  if (!isObject(devices)) return [];
  return Object.entries(devices).map(([id, device]) => {
    const name = valueAt(device, ["name"]);
    return [id, typeof name === "string" && name !== "" ? name : id];
  });
}

/** Which signal has this field already, by name; empty for none. */
export function signalOf(described: JsonObject, { topic, field }: TopicField): string {
  for (const { signals } of signalsOf(described)) {
    for (const [id, signal] of Object.entries(signals)) {
      const source = valueAt(signal, ["source"]);
      if (!isObject(source) || source["topic"] !== topic || source["field"] !== field) continue;
      const name = valueAt(signal, ["name"]);
      return typeof name === "string" && name !== "" ? name : id;
    }
  }
  return "";
}

/** What is proposed: the device that has most of the topic already, and a name made of the path. */
export function proposeSignal(described: JsonObject, wanted: TopicField): SignalWords {
  const devices = devicesOf(described).map(([id]) => id);
  const beside = (device: string): number => {
    const found = signalsOf(described).find(({ id }) => id === device);
    return Object.values(found?.signals ?? {}).filter((signal) => valueAt(signal, ["source", "topic"]) === wanted.topic).length;
  };
  const device = devices.reduce((best, other) => (beside(other) > beside(best) ? other : best), devices[0] ?? "");
  return { device, name: proposedName(wanted), unit: "" };
}

/** The description with the signal; comments and order of the text are the hub's matter. */
export function withSignal(described: JsonObject, wanted: TopicField, { device, name, unit }: SignalWords): JsonObject {
  const signals = valueAt(described, ["devices", device, "signals"]);
  const id = freeName(isObject(signals) ? signals : undefined, addressWord(name, "signal"));
  const made: Json = {
    name,
    ...(unit === "" ? {} : { unit }),
    ...(wanted.text ? { type: "text" } : {}),
    source: { topic: wanted.topic, type: wanted.type, field: wanted.field },
  };
  return changedAt(described, ["devices", device, "signals", id], made);
}

/** `/oven/bake` and `shelves[1].celsius`: Shelves 1 celsius. */
function proposedName({ topic, field }: TopicField): string {
  const words = field.split(".").flatMap((part) => part.replaceAll(/\[(\d+)\]/g, " $1").split(" "));
  const last = words.at(-1) ?? "";
  // What is called only `data` or `x` takes its meaning from what it is in.
  const before = words.length === 1 && NAMELESS.has(last) ? [topic.split("/").at(-1) ?? ""] : words.slice(-3, -1);
  const named = last === "data" || last === "value" ? before : [...before, last];
  return keyLabel(named.join(" ")).slice(0, 80);
}

function signalsOf(described: JsonObject): { readonly id: string; readonly signals: JsonObject }[] {
  return devicesOf(described).map(([id]) => {
    const signals = valueAt(described, ["devices", id, "signals"]);
    return { id, signals: isObject(signals) ? signals : {} };
  });
}
