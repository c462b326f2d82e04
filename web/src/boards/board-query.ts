/** What the address of a board says besides its key: what it is looked at with, and whether it fills the screen. Pure. */

import { templatePath, withQuery } from "../state/router.js";

export interface BoardQuery {
  readonly site: string;
  readonly device: string;
  /** It is being arranged from the first moment. */
  readonly arrange: boolean;
  /** The past moment that is shown (µs); null for now. */
  readonly at: number | null;
  /** The moment of another run that stands beside it (µs); null for none. */
  readonly against: number | null;
  /** What stands there and is no time; empty where all is well. */
  readonly wrongAt: string;
  readonly kiosk: boolean;
  /** Keys of boards that follow one another in a kiosk. */
  readonly cycle: readonly string[];
  /** Each stays so long (s). */
  readonly seconds: number;
}

const LEAST_S = 5;

export function readBoardQuery(search: string): BoardQuery {
  const said = new URLSearchParams(search);
  const at = readMoment(said.get("at") ?? "");
  const seconds = Number(said.get("seconds") ?? "");
  return {
    site: said.get("site") ?? "",
    device: said.get("device") ?? "",
    arrange: said.get("arrange") === "1",
    at,
    against: at === null ? null : readMoment(said.get("with") ?? ""),
    wrongAt: at === null ? (said.get("at") ?? "") : "",
    kiosk: said.get("kiosk") === "1",
    cycle: said.getAll("cycle").filter(Boolean),
    seconds: Number.isFinite(seconds) && seconds > 0 ? Math.max(LEAST_S, seconds) : 30,
  };
}

/** The same as the part of an address behind its question mark; what is usual is left out. */
export function writeBoardQuery({ site = "", device = "", at = null, against = null, kiosk = false, cycle = [], seconds = 30 }: Partial<BoardQuery>): string {
  const said = new URLSearchParams();
  if (site !== "") said.set("site", site);
  if (device !== "") said.set("device", device);
  if (at !== null) said.set("at", momentText(at));
  if (at !== null && against !== null) said.set("with", momentText(against));
  if (kiosk) said.set("kiosk", "1");
  for (const key of cycle) said.append("cycle", key);
  if (cycle.length > 0) said.set("seconds", String(seconds));
  return said.toString();
}

/** A moment as addresses have it: ISO 8601, UTC, to the millisecond. */
export function momentText(us: number): string {
  return new Date(Math.floor(us / 1000)).toISOString();
}

/** Where the board that is made of a site's description shows a moment (µs). */
export function boardAtPath(site: string, us: number): string {
  return withQuery(templatePath(site), writeBoardQuery({ at: us }));
}

/** With a zone or in UTC; null for what is no time, or is before 1970. */
function readMoment(text: string): number | null {
  if (!/^\d{4}-\d{2}-\d{2}(?:T\d{2}:\d{2}(?::\d{2}(?:\.\d+)?)?(?:Z|[+-]\d{2}:?\d{2})?)?$/i.test(text)) return null;
  // Without a zone a browser would take its own.
  const zoned = /T/i.test(text) && !/(?:Z|[+-]\d{2}:?\d{2})$/i.test(text) ? `${text}Z` : text;
  const ms = Date.parse(zoned);
  return Number.isFinite(ms) && ms >= 0 ? ms * 1000 : null;
}

/** The board that follows in a kiosk; empty where none does. */
export function nextInCycle(key: string, cycle: readonly string[]): string {
  if (cycle.length < 2) return "";
  return cycle[(cycle.indexOf(key) + 1) % cycle.length] ?? "";
}
