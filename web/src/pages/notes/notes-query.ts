/** Which notes are shown, as the page's address and as the hub's question; and what a new one is to say. Pure. */

import { pageQuery, queryTexts, textsQuery } from "../../format/filter-query.js";
import { boardAtPath } from "../../boards/board-query.js";
import type { NoteShape, SiteShape } from "../../generated/api.js";
import type { TimeSpan } from "../../series/time-window.js";
import { sitePath } from "../../state/router.js";

export interface NoteSearch {
  /** Words, each of which stands somewhere in the note or its author's name. */
  readonly text: string;
  readonly who: string;
  readonly device: string;
  /** µs; null for no limit. */
  readonly fromUs: number | null;
  readonly toUs: number | null;
}

/** What a dialog begins with: a new note, or one that is to be changed. */
export interface NoteDraft {
  /** Of the note that is changed; empty for a new one. */
  readonly id: string;
  readonly version: number;
  readonly device: string;
  readonly signal: string;
  readonly fromUs: number;
  /** The same as the beginning for a moment. */
  readonly toUs: number;
  readonly text: string;
}

export const SEARCH_KEYS = ["text", "who", "device"] as const;
export const NO_SEARCH: NoteSearch = { text: "", who: "", device: "", fromUs: null, toUs: null };
const LATEST_US = 2 ** 53;
/** Before and behind a note, so much is shown of the history (µs). */
const AROUND_US = 60e6;
/** A chart holds so many channels before it is hard to read. */
const MOST_CHANNELS = 6;

export function readNoteSearch(search: string): NoteSearch {
  const asked = new URLSearchParams(search);
  const readTime = (key: string): number | null => {
    const text = asked.get(key) ?? "";
    const us = Number(text);
    return text !== "" && Number.isFinite(us) && us >= 0 && us <= LATEST_US ? Math.round(us) : null;
  };
  return { ...queryTexts(asked, SEARCH_KEYS), fromUs: readTime("from"), toUs: readTime("to") };
}

/** For the address; empty for all. */
export function writeNoteSearch(search: NoteSearch): string {
  const asked = textsQuery(search, SEARCH_KEYS);
  if (search.fromUs !== null) asked.set("from", String(search.fromUs));
  if (search.toUs !== null) asked.set("to", String(search.toUs));
  return asked.toString();
}

/** The hub's question for the page behind `before`; empty for the newest. */
export function notesPageQuery(search: NoteSearch, before: string, limit: number): string {
  const asked = textsQuery(search, SEARCH_KEYS);
  if (search.fromUs !== null) asked.set("from_us", String(search.fromUs));
  if (search.toUs !== null) asked.set("to_us", String(search.toUs));
  return pageQuery(asked, before, limit);
}

/** The hub's question for all notes of which any part lies in a span, up to so many. */
export function notesSpanQuery({ fromUs, toUs }: TimeSpan, limit: number): string {
  return pageQuery(new URLSearchParams({ from_us: String(Math.max(0, Math.round(fromUs))), to_us: String(Math.round(toUs)) }), "", limit);
}

export function draftAt(fromUs: number, toUs = fromUs, device = ""): NoteDraft {
  return { id: "", version: 0, device, signal: "", fromUs: Math.round(fromUs), toUs: Math.round(toUs), text: "" };
}

export function draftOf({ id, version, device, signal, from_us, to_us, text }: NoteShape): NoteDraft {
  return { id, version, device, signal, fromUs: from_us, toUs: to_us, text };
}

/** What a note is about, by the names of the description; empty for the whole site. */
export function subjectName({ device, signal }: { readonly device: string; readonly signal: string }, detail: SiteShape | undefined): string {
  const found = detail?.devices.find(({ id }) => id === device);
  const named = found?.signals.find(({ id }) => id === signal);
  return [found?.name ?? device, named?.name ?? signal].filter(Boolean).join(" · ");
}

/** The charts around a note: of its signal, else of its device; the page chooses where it has neither. */
export function noteHistoryPath(site: string, note: NoteShape, detail: SiteShape | undefined): string {
  const device = detail?.devices.find(({ id }) => id === note.device);
  const signal = device?.signals.filter(({ id, primary }) => (note.signal === "" ? primary : id === note.signal)) ?? [];
  const asked = new URLSearchParams();
  for (const channel of signal.flatMap(({ channels }) => channels).slice(0, MOST_CHANNELS)) asked.append("c", channel);
  asked.set("from", String(note.from_us - AROUND_US));
  asked.set("to", String(note.to_us + AROUND_US));
  asked.set("at", String(note.from_us));
  return `${sitePath(site, "history")}?${asked.toString().replaceAll("%2F", "/")}`;
}

/** The site's own board at the beginning of a note. */
export function noteBoardPath(site: string, { from_us }: NoteShape): string {
  return boardAtPath(site, from_us);
}
