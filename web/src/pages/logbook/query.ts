/** What of the logbook is shown, as the page's address and as the hub's question. Pure. */

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

export const NO_FILTER: LogbookFilter = { text: "", kind: "", device: "", who: "", bad: false };

/** Kinds that people filter by: the first word of what the hub calls it. */
export const KINDS: readonly { readonly kind: string; readonly name: string }[] = [
  { kind: "", name: "Everything" },
  { kind: "alarm", name: "Alarms" },
  { kind: "command", name: "Commands" },
  { kind: "stop", name: "STOP" },
  { kind: "lease", name: "Driving" },
  { kind: "interlock", name: "Interlocks" },
  { kind: "sighting", name: "Sightings" },
  { kind: "anomaly", name: "Anomalies" },
  { kind: "gateway", name: "Connections" },
  { kind: "recording", name: "Recordings" },
];

/** Before an event in the history and behind it, so much is shown (µs). */
const AROUND_US = 60e6;

export function readFilter(search: string): LogbookFilter {
  const asked = new URLSearchParams(search);
  const text = (key: string): string => (asked.get(key) ?? "").slice(0, 200);
  return { text: text("text"), kind: text("kind"), device: text("device"), who: text("who"), bad: asked.get("good") === "false" };
}

/** The filter as a query, for the address and for the hub alike; empty for all. */
export function writeFilter(filter: LogbookFilter): string {
  const asked = new URLSearchParams();
  for (const key of ["text", "kind", "device", "who"] as const) if (filter[key] !== "") asked.set(key, filter[key]);
  if (filter.bad) asked.set("good", "false");
  return asked.toString();
}

/** The hub's question for the page behind `before`; empty for the newest. */
export function pageQuery(filter: LogbookFilter, before: string, limit: number): string {
  const asked = new URLSearchParams(writeFilter(filter));
  if (before !== "") asked.set("before", before);
  asked.set("limit", String(limit));
  return asked.toString();
}

/** The history page's query for the moment of an event. */
export function momentQuery(timeUs: number): string {
  return `from=${String(Math.round(timeUs - AROUND_US))}&to=${String(Math.round(timeUs + AROUND_US))}`;
}
