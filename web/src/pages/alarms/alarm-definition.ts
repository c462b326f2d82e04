/** An alarm's definition as the fields of a form, and back. Pure. */

import { shownDifferenceText, shownText, type Showable } from "../../format/unit.js";
import type { AlarmDefinition, AlarmKind, EscalationShape, SignalType } from "../../generated/api.js";

export const KINDS: readonly { readonly kind: AlarmKind; readonly name: string }[] = [
  { kind: "limit", name: "Limit" },
  { kind: "state", name: "State or text" },
  { kind: "stale", name: "No fresh value" },
  { kind: "expression", name: "Expression" },
  { kind: "zone", name: "Inside or outside a zone" },
  { kind: "anomaly", name: "Anomaly" },
  { kind: "detection", name: "Something a camera sees" },
  { kind: "enclosure", name: "Enclosure NOT CLOSED" },
  { kind: "gateway", name: "Gateway silent" },
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
  { name: "signal", label: "Signal", kinds: ["limit", "state", "stale", "anomaly", "zone"], sort: "signal" },
  { name: "device", label: "Or all of a device", hint: "What becomes unusual together is one alarm", kinds: ["anomaly"], sort: "device" },
  { name: "inside", label: "Raised inside", hint: "A zone of the map, by its short name", kinds: ["zone"], sort: "text" },
  { name: "outside", label: "Raised outside", hint: "Or outside of this one", kinds: ["zone"], sort: "text" },
  { name: "margin", label: "Already so near to its edge (m)", kinds: ["zone"], sort: "number" },
  { name: "stream", label: "Camera", kinds: ["detection"], sort: "stream" },
  { name: "label", label: "Detected object", hint: "As the detector calls it: person, dog, car", kinds: ["detection"], sort: "text" },
  { name: "count", label: "At least so many", kinds: ["detection"], sort: "number" },
  { name: "confidence", label: "At least so sure (0 to 1)", kinds: ["detection"], sort: "number" },
  { name: "expression", label: "Condition", hint: '{device/signal} < 11.5 and not {device/state} == "on"', kinds: ["expression"], sort: "text" },
  { name: "enclosure", label: "Enclosure", hint: "Its short name, as in the description. Empty: any", kinds: ["enclosure"], sort: "text" },
  { name: "above", label: "Raised above", kinds: ["limit"], sort: "number" },
  { name: "below", label: "Raised below", kinds: ["limit"], sort: "number" },
  { name: "hysteresis", label: "Lets go so far on the safe side", kinds: ["limit"], sort: "number" },
  { name: "is_one_of", label: "Raised in these", hint: "With commas between", kinds: ["state"], sort: "words" },
  { name: "is_not", label: "Raised in all but these", hint: "With commas between", kinds: ["state"], sort: "words" },
  { name: "score", label: "At least this score", kinds: ["anomaly"], sort: "number" },
  { name: "delay", label: "Raised after (s)", hint: "So long it must be so", kinds: ALL, sort: "number" },
  { name: "clear_delay", label: "Over after (s)", hint: "So long it must not be so", kinds: ALL, sort: "number" },
  { name: "max_age", label: "A value is unknown after (s)", hint: "Empty: as the signal has it", kinds: ["limit", "state", "stale", "expression", "anomaly", "zone"], sort: "number" },
  { name: "unknown_after", label: "Raised if unknown for (s)", hint: "When it cannot be judged. Empty: never", kinds: ALL, sort: "number" },
  { name: "repeat", label: "Repeat every (s)", hint: "Until acknowledged. Empty: notify once", kinds: ALL, sort: "number" },
  { name: "escalate", label: "Who is notified, in order", hint: "Accounts and seconds: anna 0, ben 300. Empty: everybody whose rules want it", kinds: ALL, sort: "people" },
  { name: "remind", label: "Remind every (s)", hint: "While acknowledged and still so. Empty: never", kinds: ALL, sort: "number" },
  { name: "advice", label: "What to do", kinds: ALL, sort: "text" },
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
  return `In your unit: ${(field.name === "hysteresis" ? shownDifferenceText : shownText)(signal, value)}`;
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
