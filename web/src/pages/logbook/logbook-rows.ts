/** The lines of the logbook page by page: what happened, and the notes of people at their own moments between. */

import type { EventList, EventShape, NoteList, NoteShape } from "../../generated/api.js";
import { pageQuery } from "../../format/filter-query.js";
import { logbookPageQuery, type LogbookFilter } from "./logbook-query.js";

/** A note among the lines; its id is none of an event. */
interface NoteLine {
  readonly id: string;
  readonly time_us: number;
  readonly note: NoteShape;
}

export type LogbookRow = EventShape | NoteLine;

export interface LogbookSources {
  readonly events: { events(site: string, query: string): Promise<EventList> };
  readonly notes: { findNotes(query: string): Promise<NoteList> };
}

/** Between two pages of lines there are hardly more. */
const MOST_NOTES = 1000;
const LAST_US = 2 ** 53;

/** @param last the line behind which the page begins; undefined for the newest page */
export async function readLogbookPage({ events, notes }: LogbookSources, site: string, filter: LogbookFilter, last: LogbookRow | undefined, limit: number): Promise<{ rows: readonly LogbookRow[]; more: boolean }> {
  if (filter.kind === "note") {
    const found = await notes.findNotes(pageQuery(wordsOf(filter), last === undefined ? "" : noteId(last), limit));
    return { rows: filter.bad ? [] : found.notes.map(lineOf), more: found.more && !filter.bad };
  }
  const found = await events.events(site, logbookPageQuery(filter, last?.id ?? "", limit));
  // Of other kinds, and of what went wrong, there are no notes.
  if (filter.bad || filter.kind !== "") return { rows: found.events, more: found.more };
  // With older lines to come, notes before the last line of this page wait for the next one.
  const fromUs = found.more ? (found.events.at(-1)?.time_us ?? 0) : 0;
  const beforeUs = last?.time_us ?? LAST_US;
  const asked = wordsOf(filter);
  asked.set("from_us", String(fromUs));
  asked.set("to_us", String(beforeUs));
  const noted = await notes.findNotes(pageQuery(asked, "", MOST_NOTES));
  return { rows: mergedLines(found.events, noted.notes, fromUs, beforeUs), more: found.more };
}

/** The newest first. A note counts where it begins: one that lasts into a page is a line of another. Pure. */
export function mergedLines(events: readonly EventShape[], notes: readonly NoteShape[], fromUs: number, beforeUs: number): readonly LogbookRow[] {
  const lines = notes.filter(({ from_us }) => from_us > fromUs || (fromUs === 0 && from_us === 0)).filter(({ from_us }) => from_us <= beforeUs).map(lineOf);
  return [...events, ...lines].sort((a, b) => b.time_us - a.time_us);
}

function lineOf(note: NoteShape): NoteLine {
  return { id: `note ${note.id}`, time_us: note.from_us, note };
}

function noteId(line: LogbookRow): string {
  return "note" in line ? line.note.id : "";
}

function wordsOf({ text, who, device }: LogbookFilter): URLSearchParams {
  return new URLSearchParams(Object.entries({ text, who, device }).filter(([, value]) => value !== ""));
}
