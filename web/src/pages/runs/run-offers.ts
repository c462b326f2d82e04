/** Runs that can be put beside each other: what was recorded, and what people wrote about. Pure. */

import type { NoteShape, RecordingShape } from "../../generated/api.js";
import type { TimeSpan } from "../../series/time-window.js";

/** A stretch of time with a name; one that ends where it begins is a mark, at which runs are laid over each other. */
export interface RunOffer extends TimeSpan {
  readonly id: string;
  readonly name: string;
}

/** Compared from a mark on, where neither run says how long it is (µs). */
const FROM_MARK_US = 300e6;
const LONGEST_NAME = 60;

/** The last to begin first. */
export function runOffers(recordings: readonly RecordingShape[], notes: readonly NoteShape[]): readonly RunOffer[] {
  const recorded = recordings.filter(({ begin_us, end_us }) => end_us > begin_us).map(({ id, begin_us, end_us, note, stream }): RunOffer => ({ id: `recording ${id}`, name: `${stream === "" ? "Recording" : "Film"}${note === "" ? "" : `: ${shortName(note)}`}`, fromUs: begin_us, toUs: end_us }));
  const noted = notes.map(({ id, from_us, to_us, text }): RunOffer => ({ id: `note ${id}`, name: `Note: ${shortName(text)}`, fromUs: from_us, toUs: to_us }));
  return [...recorded, ...noted].sort((a, b) => b.fromUs - a.fromUs);
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
