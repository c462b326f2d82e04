/** What the history page shows, as it stands in the address bar. */

import { msg, str } from "@lit/localize";
import { plural } from "../../words/plural.js";
import type { TimeSpan } from "../../series/time-window.js";
import { KINDS, type MarkKind } from "./chart/event-marks.js";
import { LEAST_K, MOST_K } from "../../series/outliers.js";
import { SECOND_US, type ZoneClock } from "../../series/zone-clock.js";

export interface HistoryView {
  /** Addresses of the chosen channels; null when the address says nothing of them. */
  readonly channels: readonly string[] | null;
  /** The last so many seconds, going on with the time; or a window that stands still. */
  readonly shown: { readonly last: number } | TimeSpan;
  /** Numbers of several units share a chart, with an axis for each unit. */
  readonly joined: boolean;
  /** Kinds of events that are not shown. */
  readonly without: readonly MarkKind[];
  /** The window so many days before is drawn behind (negative: after); 0 for none. */
  readonly versus: number;
  /** Another run lies behind, so much before (µs; negative: after), in place of another day; 0 for none. */
  readonly shiftUs: number;
  /** Outliers are pointed out beyond so many times the distance of the quartiles; 0 for none. */
  readonly outliers: number;
  /** The moment (µs) that films and cursor begin at. */
  readonly at?: number | undefined;
  /** Cameras whose films are shown; when it is missing, the first of them. */
  readonly films?: readonly string[] | undefined;
}

export const FIRST_LAST = 900;
const LONGEST_LAST = 3660 * 86_400;

/** Reads the search part of the address. What makes no sense is as if it were not there. */
export function readView(search: string): HistoryView {
  const query = new URLSearchParams(search);
  const channels = query.has("none") ? [] : query.getAll("c");
  return {
    channels: channels.length > 0 || query.has("none") ? [...new Set(channels)] : null,
    shown: readShown(query),
    joined: query.has("joined"),
    without: KINDS.map(({ kind }) => kind).filter((kind) => (query.get("without") ?? "").split(",").includes(kind)),
    versus: readVersus(query),
    shiftUs: readShift(query),
    outliers: readOutliers(query),
    at: readAt(query),
    films: query.has("film") ? query.getAll("film").filter((stream) => stream !== "") : undefined,
  };
}

/** The search part for a view: what `readView` reads back. */
export function writeView(view: HistoryView): string {
  const query = new URLSearchParams();
  for (const channel of view.channels ?? []) query.append("c", channel);
  if (view.channels?.length === 0) query.set("none", "");
  if ("last" in view.shown) {
    query.set("last", String(view.shown.last));
  } else {
    query.set("from", String(Math.round(view.shown.fromUs)));
    query.set("to", String(Math.round(view.shown.toUs)));
  }
  if (view.without.length > 0) query.set("without", view.without.join(","));
  if (view.versus !== 0) query.set("versus", String(view.versus));
  if (view.shiftUs !== 0) query.set("shift", String(Math.round(view.shiftUs)));
  if (view.outliers !== 0) query.set("outliers", String(view.outliers));
  if (view.joined) query.set("joined", "");
  if (view.at !== undefined) query.set("at", String(Math.round(view.at)));
  for (const stream of view.films ?? []) query.append("film", stream);
  if (view.films?.length === 0) query.set("film", "");
  // Slashes and commas may stand in a query, and addresses read better with them.
  return `?${query.toString().replaceAll("%2F", "/").replaceAll("%2C", ",").replaceAll(/=(?=&|$)/g, "")}`;
}

const MOST_DAYS = 3660;

function readVersus(query: URLSearchParams): number {
  const days = Number(query.get("versus") ?? 0);
  return Number.isInteger(days) && Math.abs(days) <= MOST_DAYS ? days : 0;
}

function readShift(query: URLSearchParams): number {
  const us = Number(query.get("shift") ?? 0);
  return Number.isSafeInteger(us) ? us : 0;
}

function readOutliers(query: URLSearchParams): number {
  const k = Number(query.get("outliers") ?? 0);
  return k >= LEAST_K && k <= MOST_K ? k : 0;
}

function readAt(query: URLSearchParams): number | undefined {
  const at = Number(query.get("at") ?? NaN);
  return Number.isSafeInteger(at) && at > 0 ? at : undefined;
}

/** How much before the shown window the other one lies (µs); whole days of the site's zone. */
export function ghostUs(span: TimeSpan, { versus, shiftUs }: Pick<HistoryView, "versus" | "shiftUs">, clock: ZoneClock): number {
  if (shiftUs !== 0) return shiftUs;
  return versus === 0 ? 0 : span.fromUs - clock.sameTime(span.fromUs, -versus);
}

/** How far the other day is away: `1 day before`. */
export function comparedDaysText(versus: number): string {
  const days = Math.abs(versus);
  return plural(days, versus > 0 ? msg(str`${String(days)} day before`) : msg(str`${String(days)} day after`), versus > 0 ? msg(str`${String(days)} days before`) : msg(str`${String(days)} days after`));
}

function readShown(query: URLSearchParams): { last: number } | TimeSpan {
  const [fromUs, toUs, last] = ["from", "to", "last"].map((key) => Number(query.get(key) ?? NaN));
  if (fromUs !== undefined && toUs !== undefined && Number.isSafeInteger(fromUs) && Number.isSafeInteger(toUs) && fromUs < toUs) {
    return { fromUs, toUs };
  }
  return { last: last !== undefined && last >= 1 && last <= LONGEST_LAST ? last : FIRST_LAST };
}

export interface QuickRange {
  readonly id: string;
  readonly label: string;
}

export const QUICK: readonly QuickRange[] = [
  { id: "300", label: "5 min" },
  { id: "900", label: "15 min" },
  { id: "3600", label: "1 h" },
  { id: "21600", label: "6 h" },
  { id: "86400", label: "24 h" },
  { id: "604800", label: "7 d" },
  { id: "today", label: msg("Today") },
  { id: "yesterday", label: msg("Yesterday") },
];

/** What a quick range shows; days are those of the site's zone. */
export function quickShown(id: string, nowUs: number, clock: ZoneClock): { last: number } | TimeSpan {
  switch (id) {
    case "today":
      return { fromUs: clock.dayStart(nowUs), toUs: clock.dayAfter(nowUs, 1) };
    case "yesterday":
      return { fromUs: clock.dayAfter(nowUs, -1), toUs: clock.dayStart(nowUs) };
    default:
      return { last: Number(id) };
  }
}

/** Which quick range is shown; empty for none. */
export function quickOf(shown: HistoryView["shown"], nowUs: number, clock: ZoneClock): string {
  if ("last" in shown) return QUICK.some(({ id }) => id === String(shown.last)) ? String(shown.last) : "";
  const isSameRange = (id: string): boolean => {
    const span = quickShown(id, nowUs, clock);
    return !("last" in span) && span.fromUs === shown.fromUs && span.toUs === shown.toUs;
  };
  return ["today", "yesterday"].find(isSameRange) ?? "";
}

/** The window at a moment. */
export function spanOf(shown: HistoryView["shown"], nowUs: number): TimeSpan {
  return "last" in shown ? { fromUs: nowUs - shown.last * SECOND_US, toUs: nowUs } : shown;
}
