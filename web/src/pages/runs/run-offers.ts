/** Runs that can be put beside each other: what was recorded or driven, what was unusual, and what people wrote about. Pure. */

import { msg, str } from "@lit/localize";
import type { EventShape, NoteShape, RecordingShape } from "../../generated/api.js";
import type { TimeSpan } from "../../series/time-window.js";

/** A stretch of time with a name; one that ends where it begins is a mark, at which runs are laid over each other. */
export interface RunOffer extends TimeSpan {
  readonly id: string;
  readonly name: string;
}

/** Compared from a mark on, where neither run says how long it is (µs). */
const FROM_MARK_US = 300e6;
const LONGEST_NAME = 60;

/** Beginnings of the kinds of lines that `eventRuns` reads. */
export const RUN_KINDS = "lease,anomaly";

/** The last to begin first. */
export function runOffers(recordings: readonly RecordingShape[], notes: readonly NoteShape[], events: readonly EventShape[] = []): readonly RunOffer[] {
  const recorded = recordings.filter(({ begin_us, end_us }) => end_us > begin_us).map(({ id, begin_us, end_us, note, stream }): RunOffer => ({ id: `recording ${id}`, name: stream === "" ? msg(str`Recording${note === "" ? "" : `: ${shortName(note)}`}`) : msg(str`Film${note === "" ? "" : `: ${shortName(note)}`}`), fromUs: begin_us, toUs: end_us }));
  const noted = notes.map(({ id, from_us, to_us, text }): RunOffer => ({ id: `note ${id}`, name: msg(str`Note: ${shortName(text)}`), fromUs: from_us, toUs: to_us }));
  return [...recorded, ...noted, ...eventRuns(events)].sort((a, b) => b.fromUs - a.fromUs);
}

/**
 * Drives, from a lease that was taken until it was freed or went to somebody else, and anomalies, from their beginning
 * to their end. What goes on still, or began before the lines do, is none.
 *
 * @param events of the logbook, the newest first
 */
export function eventRuns(events: readonly EventShape[]): readonly RunOffer[] {
  const found: RunOffer[] = [];
  const begun = new Map<string, EventShape>();
  const end = (key: string, name: string, toUs: number): void => {
    const first = begun.get(key);
    begun.delete(key);
    if (first !== undefined && toUs > first.time_us) found.push({ id: `${key} ${first.id}`, name: name + (first.who === "" ? "" : msg(str` by ${first.who}`)), fromUs: first.time_us, toUs });
  };
  for (const event of [...events].reverse()) {
    const { kind, device, message, time_us: us } = event;
    const [subject = ""] = message.split(":", 1);
    const drive = `drive ${device}`;
    const anomaly = `anomaly ${device} ${subject}`;
    if (kind === "lease taken" || kind === "lease freed") end(drive, msg(str`Drive of ${device}`), us);
    if (kind === "anomaly ended") end(anomaly, msg(str`Anomaly: ${shortName(subject)}`), us);
    if (kind === "lease taken") begun.set(drive, event);
    // Several detectors of one signal: the first to begin counts.
    if (kind === "anomaly began" && !begun.has(anomaly)) begun.set(anomaly, { ...event, who: "" });
  }
  return found;
}

/** The first run's window, and how much later it is than the second one (µs): they are aligned at their starts. */
export function alignRuns(first: TimeSpan, second: TimeSpan): { readonly span: TimeSpan; readonly shiftUs: number } {
  const length = first.toUs - first.fromUs || second.toUs - second.fromUs || FROM_MARK_US;
  return { span: { fromUs: first.fromUs, toUs: first.fromUs + length }, shiftUs: first.fromUs - second.fromUs };
}

function shortName(text: string): string {
  const [line = ""] = text.split("\n", 1);
  return line.length > LONGEST_NAME ? `${line.slice(0, LONGEST_NAME)}…` : line;
}
