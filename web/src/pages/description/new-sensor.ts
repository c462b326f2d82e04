/** Sensors that a robot says by name and no signal is of: from the logbook into the description, in one click. */

import { addressWord, changedAt, freeName, isObject, keyLabel, valueAt, type Json, type JsonObject } from "./json-schema.js";

/** A sensor of a topic that carries many by name, and the device whose signals come from that topic. */
export interface NewSensor {
  readonly site: string;
  readonly device: string;
  readonly topic: string;
  readonly name: string;
}

// As a gateway says it: `UnreadableReports.report_new_sensor`.
const SENTENCE = /^(\/\S+): (.+) is not in the description$/;

/** The sensor that a line of the logbook is about; null where it is about something else. */
export function newSensorOf(site: string, row: { readonly kind: string; readonly device: string; readonly message: string }): NewSensor | null {
  const [, topic, name] = (row.kind === "new_sensor" && SENTENCE.exec(row.message)) || [];
  return topic === undefined || name === undefined ? null : { site, device: row.device, topic, name };
}

/** Where its signal is added. */
export function newSensorPath(sensor: NewSensor): string {
  return `/admin/description?${new URLSearchParams({ ...sensor }).toString()}`;
}

/** The sensor that an address asks to add; null for none. */
export function readNewSensor(search: string): NewSensor | null {
  const asked = new URLSearchParams(search);
  const [site, device, topic, name] = ["site", "device", "topic", "name"].map((key) => asked.get(key) ?? "");
  return site && device && topic && name ? { site, device, topic, name } : null;
}

/** The description with a signal of the sensor; the same object where it has one, or no place for it. */
export function withSensor(described: JsonObject, { device, topic, name }: NewSensor): JsonObject {
  const signals = valueAt(described, ["devices", device, "signals"]);
  if (!isObject(signals)) return described;
  const sources = Object.values(signals).map((signal) => valueAt(signal, ["source"]));
  const beside = sources.filter(isObject).filter((source) => source["topic"] === topic);
  const [source] = beside;
  if (source === undefined || beside.some((other) => other["name"] === name)) return described;
  const word = freeName(signals, addressWord(name, "sensor"));
  const made: Json = { name: keyLabel(name), source: { topic, type: source["type"] ?? "", name } };
  return changedAt(described, ["devices", device, "signals", word], made);
}
