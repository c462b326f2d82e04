/** Notes as marks on the time axis. Pure. */

import { msg } from "@lit/localize";
import type { NoteShape } from "../../generated/api.js";
import type { EventMark } from "../history/chart/event-marks.js";

/** @param names of devices by their id */
export function noteMarks(notes: readonly NoteShape[], names: ReadonlyMap<string, string>): EventMark[] {
  return notes.map(({ from_us, to_us, device, who, text }): EventMark => {
    const mark = { timeUs: from_us, kind: "note", title: msg("note"), device: names.get(device) ?? device, who, message: text, good: true } as const;
    return to_us > from_us ? { ...mark, untilUs: to_us } : mark;
  });
}
