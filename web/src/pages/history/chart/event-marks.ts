/** What happened, as marks on the time axis. */

import type { EventShape } from "../../../generated/api.js";
import { lengthOf, type TimeSpan } from "../../../series/time-window.js";

export type MarkKind = "alarm" | "stop" | "command" | "driving" | "anomaly" | "sighting" | "recording" | "link" | "other";

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
  { kind: "alarm", name: "Alarms" },
  { kind: "stop", name: "STOP" },
  { kind: "command", name: "Commands" },
  { kind: "driving", name: "Driving" },
  { kind: "anomaly", name: "Anomalies" },
  { kind: "sighting", name: "Sightings" },
  { kind: "recording", name: "Recordings" },
  { kind: "link", name: "Connection" },
  { kind: "other", name: "Other events" },
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
      timeUs: time_us, kind: kindOf(kind), title: kind.replaceAll("_", " "), device: names.get(device) ?? device, who, message, good,
    }))
    .sort((a, b) => a.timeUs - b.timeUs);
}

/** @param apart marks nearer than this part of the window are put together */
export function clusterMarks(marks: readonly EventMark[], span: TimeSpan, apart: number): MarkCluster[] {
  const found: EventMark[][] = [];
  const within = apart * lengthOf(span);
  for (const mark of marks) {
    if (mark.timeUs < span.fromUs || mark.timeUs > span.toUs) continue;
    const last = found.at(-1);
    if (last?.[0] !== undefined && mark.timeUs - last[0].timeUs < within) last.push(mark);
    else found.push([mark]);
  }
  return found.map((own) => ({
    timeUs: own.reduce((sum, { timeUs }) => sum + timeUs / own.length, 0),
    marks: own,
    kind: KINDS.find(({ kind }) => own.some((mark) => mark.kind === kind))?.kind ?? "other",
    good: own.every(({ good }) => good),
  }));
}
