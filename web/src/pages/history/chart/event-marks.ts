/** What happened, as marks on the time axis. */

import { msg } from "@lit/localize";
import { eventWords } from "../../../format/kinds/event-kinds.js";
import type { EventShape } from "../../../generated/api.js";
import { lengthOf, type TimeSpan } from "../../../series/time-window.js";

export type MarkKind = "alarm" | "stop" | "command" | "driving" | "anomaly" | "sighting" | "recording" | "note" | "link" | "other";

export interface EventMark {
  readonly timeUs: number;
  readonly kind: MarkKind;
  /** What happened, as the hub says it: `command asked`. */
  readonly title: string;
  /** Name of the device; empty for the whole site. */
  readonly device: string;
  readonly who: string;
  readonly message: string;
  readonly good: boolean;
  /** It lasted until then. */
  readonly untilUs?: number;
}

/** Marks that are too near to each other to be told apart. */
export interface MarkCluster {
  readonly timeUs: number;
  readonly marks: readonly EventMark[];
  /** The most serious kind among them. */
  readonly kind: MarkKind;
  readonly good: boolean;
}

/** The most serious first. */
export const KINDS: readonly { readonly kind: MarkKind; readonly name: string }[] = [
  { kind: "alarm", name: msg("Alarms") },
  { kind: "stop", name: "STOP" },
  { kind: "command", name: msg("Commands") },
  { kind: "driving", name: msg("Driving") },
  { kind: "anomaly", name: msg("Anomalies") },
  { kind: "sighting", name: msg("Sightings") },
  { kind: "recording", name: msg("Recordings") },
  { kind: "note", name: msg("Notes") },
  { kind: "link", name: msg("Connection") },
  { kind: "other", name: msg("Other events") },
];

const WORDS: Readonly<Record<string, MarkKind>> = { alarm: "alarm", stop: "stop", command: "command", lease: "driving", drive: "driving", anomaly: "anomaly", sighting: "sighting", recording: "recording", gateway: "link" };

/** The kind that an event's first word tells. */
export function kindOf(title: string): MarkKind {
  return WORDS[title.split(/[ _]/, 1)[0] ?? ""] ?? "other";
}

/** @param names of devices by their id */
export function eventMarks(events: readonly EventShape[], names: ReadonlyMap<string, string>): EventMark[] {
  return events
    .map(({ time_us, kind, device, who, message, good }) => ({
      timeUs: time_us, kind: kindOf(kind), title: eventWords(kind), device: names.get(device) ?? device, who, message, good,
    }))
    .sort((a, b) => a.timeUs - b.timeUs);
}

/** Both in the order of time. */
export function mergeMarks(...lists: readonly (readonly EventMark[])[]): EventMark[] {
  return lists.flat().sort((a, b) => a.timeUs - b.timeUs);
}

/** @param apart marks nearer than this part of the window are put together */
export function clusterMarks(marks: readonly EventMark[], span: TimeSpan, apart: number): MarkCluster[] {
  const found: { readonly us: number; readonly mark: EventMark }[][] = [];
  const within = apart * lengthOf(span);
  for (const mark of marks) {
    // What lasts into the window stands at its edge.
    const us = mark.untilUs !== undefined && mark.untilUs >= span.fromUs ? Math.max(mark.timeUs, span.fromUs) : mark.timeUs;
    if (us < span.fromUs || us > span.toUs) continue;
    const last = found.at(-1);
    if (last?.[0] !== undefined && us - last[0].us < within) last.push({ us, mark });
    else found.push([{ us, mark }]);
  }
  return found.map((placed) => ({ timeUs: placed.reduce((sum, { us }) => sum + us / placed.length, 0), own: placed.map(({ mark }) => mark) })).map(({ timeUs, own }) => ({
    timeUs,
    marks: own,
    kind: KINDS.find(({ kind }) => own.some((mark) => mark.kind === kind))?.kind ?? "other",
    good: own.every(({ good }) => good),
  }));
}
