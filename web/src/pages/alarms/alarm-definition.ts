/** An alarm's definition as the fields of a form, and back. Pure. */

import { msg, str } from "@lit/localize";
import { shownDifferenceText, shownText, type Showable } from "../../format/unit.js";
import type { AlarmDefinition, AlarmKind, EscalationShape, SignalType } from "../../generated/api.js";

export const KINDS: readonly { readonly kind: AlarmKind; readonly name: string }[] = [
  { kind: "limit", name: msg("Limit") },
  { kind: "state", name: msg("State or text") },
  { kind: "stale", name: msg("No fresh value") },
  { kind: "expression", name: msg("Expression") },
  { kind: "zone", name: msg("Inside or outside a zone") },
  { kind: "anomaly", name: msg("Anomaly") },
  { kind: "detection", name: msg("Something a camera sees") },
  { kind: "enclosure", name: msg("Enclosure NOT CLOSED") },
  { kind: "gateway", name: msg("Gateway silent") },
];

/** Texts of the form's fields, by name; a ticked box is "on". */
export type AlarmFields = Readonly<Record<string, string>>;

export interface AlarmField {
  readonly name: string;
  readonly label: string;
  readonly hint?: string;
  readonly kinds: readonly AlarmKind[];
  readonly sort: "number" | "text" | "words" | "signal" | "device" | "stream" | "people";
}

const ALL = KINDS.map(({ kind }) => kind);

/** Every field, in the order of the form, with the kinds that have it. */
export const FIELDS: readonly AlarmField[] = [
  { name: "signal", label: msg("Signal"), kinds: ["limit", "state", "stale", "anomaly", "zone"], sort: "signal" },
  { name: "device", label: msg("Or all of a device"), hint: msg("What becomes unusual together is one alarm"), kinds: ["anomaly"], sort: "device" },
  { name: "inside", label: msg("Raised inside"), hint: msg("A zone of the map, by its short name"), kinds: ["zone"], sort: "text" },
  { name: "outside", label: msg("Raised outside"), hint: msg("Or outside of this one"), kinds: ["zone"], sort: "text" },
  { name: "margin", label: msg("Already so near to its edge (m)"), kinds: ["zone"], sort: "number" },
  { name: "stream", label: msg("Camera"), kinds: ["detection"], sort: "stream" },
  { name: "label", label: msg("Detected object"), hint: msg("As the detector calls it: person, dog, car"), kinds: ["detection"], sort: "text" },
  { name: "count", label: msg("At least so many"), kinds: ["detection"], sort: "number" },
  { name: "confidence", label: msg("At least so sure (0 to 1)"), kinds: ["detection"], sort: "number" },
  { name: "expression", label: msg("Condition"), hint: '{device/signal} < 11.5 and not {device/state} == "on"', kinds: ["expression"], sort: "text" },
  { name: "enclosure", label: msg("Enclosure"), hint: msg("Its short name, as in the description. Empty: any"), kinds: ["enclosure"], sort: "text" },
  { name: "above", label: msg("Raised above"), kinds: ["limit"], sort: "number" },
  { name: "below", label: msg("Raised below"), kinds: ["limit"], sort: "number" },
  { name: "hysteresis", label: msg("Lets go so far on the safe side"), kinds: ["limit"], sort: "number" },
  { name: "is_one_of", label: msg("Raised in these"), hint: msg("With commas between"), kinds: ["state"], sort: "words" },
  { name: "is_not", label: msg("Raised in all but these"), hint: msg("With commas between"), kinds: ["state"], sort: "words" },
  { name: "score", label: msg("At least this score"), kinds: ["anomaly"], sort: "number" },
  { name: "delay", label: msg("Raised after (s)"), hint: msg("So long it must be so"), kinds: ALL, sort: "number" },
  { name: "clear_delay", label: msg("Over after (s)"), hint: msg("So long it must not be so"), kinds: ALL, sort: "number" },
  { name: "max_age", label: msg("A value is unknown after (s)"), hint: msg("Empty: as the signal has it"), kinds: ["limit", "state", "stale", "expression", "anomaly", "zone"], sort: "number" },
  { name: "unknown_after", label: msg("Raised if unknown for (s)"), hint: msg("When it cannot be judged. Empty: never"), kinds: ALL, sort: "number" },
  { name: "repeat", label: msg("Repeat every (s)"), hint: msg("Until acknowledged. Empty: notify once"), kinds: ALL, sort: "number" },
  { name: "escalate", label: msg("Who is notified, in order"), hint: msg("Accounts and seconds: anna 0, ben 300. Empty: everybody whose rules want it"), kinds: ALL, sort: "people" },
  { name: "remind", label: msg("Remind every (s)"), hint: msg("While acknowledged and still so. Empty: never"), kinds: ALL, sort: "number" },
  { name: "advice", label: msg("What to do"), kinds: ALL, sort: "text" },
];

/** Fields whose number is in the signal's unit. */
const IN_UNIT = ["above", "below", "hysteresis"];

/** What a field is called, with the unit of its number. */
export function fieldLabel(field: AlarmField, unit: string): string {
  return IN_UNIT.includes(field.name) && unit !== "" ? `${field.label} (${unit})` : field.label;
}

/** What a limit is in the unit in which the person sees the signal; empty where that is its own. */
export function shownHint(field: AlarmField, text: string, signal: Showable | undefined): string {
  const value = text.trim() === "" ? Number.NaN : Number(text.trim().replace(",", "."));
  if (!IN_UNIT.includes(field.name) || signal === undefined || signal.shown === null || Number.isNaN(value)) return "";
  return msg(str`In your unit: ${(field.name === "hysteresis" ? shownDifferenceText : shownText)(signal, value)}`);
}

/** Whether an alarm of a kind can watch a signal of a type. */
export function kindFitsType(kind: AlarmKind, type: SignalType): boolean {
  if (kind === "limit" || kind === "anomaly") return type === "number" || type === "position";
  if (kind === "zone") return type === "position";
  if (kind === "state") return type === "state" || type === "text";
  return true;
}

/** Numbers that may be left empty; the others are their default then. */
const OPTIONAL = ["above", "below", "max_age", "unknown_after", "repeat", "remind"];
const FIRST: Readonly<Record<string, number>> = { count: 1, confidence: 0.5 };

/** The form's texts for a definition. */
export function alarmFields(definition: AlarmDefinition): AlarmFields {
  const said: Record<string, string> = {};
  for (const [name, value] of Object.entries(definition)) {
    if (value === null || value === undefined) said[name] = "";
    else if (Array.isArray(value)) said[name] = value.map((step: string | EscalationShape) => (typeof step === "string" ? step : `${step.who} ${String(step.after)}`)).join(", ");
    else if (typeof value === "boolean") said[name] = value ? "on" : "";
    else said[name] = String(value);
  }
  return said;
}

/** The definition that a form says; a text where a number is wanted gives what is wrong, by field. */
export function definitionOf(fields: AlarmFields): { readonly definition: AlarmDefinition } | { readonly wrong: string } {
  const kind = (fields["kind"] ?? "limit") as AlarmKind;
  const said: Record<string, unknown> = {
    name: (fields["name"] ?? "").trim(),
    kind,
    severity: fields["severity"] ?? "warning",
    record: fields["record"] === "on",
  };
  for (const { name: name, kinds, sort } of FIELDS) {
    const text = (fields[name] ?? "").trim();
    if (!kinds.includes(kind)) continue;
    if (sort === "people") {
      const steps = parseSteps(text);
      if (steps === null) return { wrong: name };
      said[name] = steps;
    } else if (sort === "words") said[name] = text.split(",").map((word) => word.trim()).filter(Boolean);
    else if (sort !== "number") said[name] = text;
    else if (text === "") said[name] = OPTIONAL.includes(name) ? null : (FIRST[name] ?? 0);
    else {
      const number = Number(text.replace(",", "."));
      if (!Number.isFinite(number)) return { wrong: name };
      said[name] = number;
    }
  }
  // An alarm about a device is about none of its signals alone.
  if ((said["device"] ?? "") !== "") said["signal"] = "";
  return { definition: said as unknown as AlarmDefinition };
}

/** `anna 0, ben 300` as steps; null when it is not of this form. */
function parseSteps(text: string): readonly EscalationShape[] | null {
  const steps: EscalationShape[] = [];
  for (const word of text.split(",").map((address) => address.trim()).filter(Boolean)) {
    const [, who, after] = /^(\S+)(?:\s+(\d+(?:\.\d+)?))?$/.exec(word) ?? [];
    if (who === undefined) return null;
    steps.push({ who, after: Number(after ?? 0) });
  }
  return steps;
}

/** A short name of a name: what the hub takes. */
export function idOf(name: string): string {
  const plain = name.normalize("NFKD").toLowerCase().replaceAll(/[^a-z0-9]+/g, "_").replaceAll(/^[_0-9]+|_+$/g, "");
  return plain.slice(0, 60) || "alarm";
}
