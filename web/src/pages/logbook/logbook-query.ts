/** What of the logbook is shown, as the page's address and as the hub's question. Pure. */

import { msg } from "@lit/localize";
import { pageQuery, queryTexts, textsQuery } from "../../format/filter-query.js";

export interface LogbookFilter {
  /** Words that stand anywhere in it. */
  readonly text: string;
  /** Begin of the kind: `alarm` finds all about alarms. */
  readonly kind: string;
  readonly device: string;
  readonly who: string;
  /** Only what somebody should look at. */
  readonly bad: boolean;
}

export const FILTER_KEYS = ["text", "kind", "device", "who"] as const;
export const NO_FILTER: LogbookFilter = { text: "", kind: "", device: "", who: "", bad: false };

/** Kinds that people filter by: the first words of what the hub calls them. */
export const KINDS: readonly { readonly kind: string; readonly name: string }[] = [
  { kind: "", name: msg("Everything") },
  { kind: "alarm", name: msg("Alarms") },
  { kind: "command", name: msg("Commands") },
  { kind: "stop", name: "STOP" },
  { kind: "lease", name: msg("Driving") },
  { kind: "interlock,enclosure", name: msg("Interlocks and roofs") },
  { kind: "sighting", name: msg("Sightings") },
  { kind: "anomaly", name: msg("Anomalies") },
  { kind: "gateway,connection,device", name: msg("Connections") },
  { kind: "recording", name: msg("Recordings") },
  { kind: "note", name: msg("Notes") },
  { kind: "description", name: msg("Description") },
];

/** Before an event in the history and behind it, so much is shown (µs). */
const AROUND_US = 60e6;

export function readLogbookFilter(search: string): LogbookFilter {
  const asked = new URLSearchParams(search);
  return { ...queryTexts(asked, FILTER_KEYS), bad: asked.get("good") === "false" };
}

/** The filter as a query, for the address and for the hub alike; empty for all. */
export function writeLogbookFilter(filter: LogbookFilter): string {
  const asked = textsQuery(filter, FILTER_KEYS);
  if (filter.bad) asked.set("good", "false");
  return asked.toString();
}

/** The hub's question for the page behind `before`; empty for the newest. */
export function logbookPageQuery(filter: LogbookFilter, before: string, limit: number): string {
  return pageQuery(writeLogbookFilter(filter), before, limit);
}

/** Whether what is in sight now fits: it has no line yet, so words are not looked for in it. */
export function showsCurrentSightings({ text, kind, device, who, bad }: LogbookFilter): boolean {
  return text === "" && device === "" && who === "" && !bad && (kind === "" || kind === "sighting");
}

/** A chart holds so many channels before it is hard to read. */
const MOST_CHANNELS = 6;

/**
 * The history page's query for the moment of an event.
 *
 * @param channels of the event's device; the page chooses where there are none
 */
export function momentQuery(timeUs: number, channels: readonly string[] = []): string {
  const chosen = channels.slice(0, MOST_CHANNELS).map((channel) => `c=${encodeURIComponent(channel).replaceAll("%2F", "/")}&`);
  return `${chosen.join("")}from=${String(Math.round(timeUs - AROUND_US))}&to=${String(Math.round(timeUs + AROUND_US))}&at=${String(Math.round(timeUs))}`;
}

/** The recording that holds a moment; undefined where nothing was recorded then. */
export function recordingAt<R extends { readonly begin_us: number; readonly end_us: number }>(recordings: readonly R[], timeUs: number): R | undefined {
  return recordings.find(({ begin_us: begin, end_us: end }) => begin <= timeUs && timeUs <= end);
}
