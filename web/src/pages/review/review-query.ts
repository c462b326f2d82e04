/** Which sightings are looked through, as the page's address and as the hub's question. Pure. */

import { pageQuery, queryTexts, textsQuery } from "../../format/filter-query.js";
import type { FilmListShape, FilmShape, ReviewDay, SeenShape } from "../../generated/api.js";
import type { ZoneClock } from "../../series/zone-clock.js";

export interface ReviewFilter {
  /** The stream, `device/stream`; empty for all. */
  readonly camera: string;
  readonly label: string;
  /** What a zone or a line is called; empty for anywhere. */
  readonly zone: string;
  /** Of the site's own time, `2026-11-26`; empty for the newest. */
  readonly day: string;
  /** Also what was looked at. */
  readonly all: boolean;
  /** The sighting that is shown first; empty for the newest. */
  readonly sighting: string;
  /** Only what began up to then (µs): a day may hold more than is loaded before that sighting; empty for all. */
  readonly until: string;
}

/** A day with what all its cameras saw. */
export interface DayCount {
  readonly day: string;
  readonly count: number;
  readonly unseen: number;
}

const TEXTS = ["camera", "label", "zone", "day", "sighting", "until"] as const;
const DAY = /^\d{4}-\d{2}-\d{2}$/;
const DAY_MS = 86_400_000;

export function readReviewFilter(search: string): ReviewFilter {
  const asked = new URLSearchParams(search);
  const texts = queryTexts(asked, TEXTS);
  return { ...texts, day: DAY.test(texts.day) ? texts.day : "", until: /^\d{1,16}$/.test(texts.until) ? texts.until : "", all: asked.get("all") === "true" };
}

/** For the address; empty for what is unseen of the newest day. */
export function writeReviewFilter(filter: ReviewFilter): string {
  const asked = textsQuery(filter, TEXTS);
  if (filter.all) asked.set("all", "true");
  return asked.toString();
}

/** The days, the newest first, with all cameras together. */
export function dayCounts(rows: readonly ReviewDay[]): DayCount[] {
  const days = new Map<string, DayCount>();
  for (const { day, count, unseen } of rows) {
    const known = days.get(day) ?? { day, count: 0, unseen: 0 };
    days.set(day, { day, count: known.count + count, unseen: known.unseen + unseen });
  }
  return [...days.values()];
}

/** The day that is meant: the one that is named, or the newest with something to be looked at. */
export function shownDay(filter: ReviewFilter, days: readonly DayCount[]): string {
  if (filter.day !== "") return filter.day;
  const open = filter.all ? undefined : days.find(({ unseen }) => unseen > 0);
  return (open ?? days[0])?.day ?? "";
}

/** The hub's question for what began on a day, behind `before`. */
export function reviewPageQuery(filter: ReviewFilter, day: string, clock: ZoneClock, before: string, limit: number): string {
  const asked = new URLSearchParams();
  for (const key of ["camera", "label", "zone"] as const) if (filter[key] !== "") asked.set(key, filter[key]);
  const [from, to] = dayBounds(day, clock);
  if (Number.isFinite(from) && Number.isFinite(to)) {
    asked.set("from_us", String(from));
    asked.set("to_us", String(filter.until === "" ? to - 1 : Math.min(to - 1, Number(filter.until))));
  }
  if (!filter.all) asked.set("unseen", "true");
  return pageQuery(asked, before, limit);
}

/** When a day of the zone begins and ends (µs). */
export function dayBounds(day: string, clock: ZoneClock): readonly [number, number] {
  const next = DAY.test(day) ? new Date(Date.parse(`${day}T00:00:00Z`) + DAY_MS).toISOString().slice(0, 10) : "";
  return [clock.fromInput(`${day} 00:00:00`), clock.fromInput(`${next} 00:00:00`)];
}

/** The film that shows a sighting's beginning, and where in it (s) that is; null where there is none. */
export function clipOf(list: FilmListShape, sighting: SeenShape, before: number): { readonly film: FilmShape; readonly from: number } | null {
  const there = list.films.filter(({ stream, begin_us, end_us }) => stream === sighting.camera && begin_us <= sighting.began_us + CLIP_LATE_US && end_us >= sighting.began_us);
  // Of two that have it the one that reaches farther back.
  const [film] = [...there].sort((a, b) => Number(b.state === "complete") - Number(a.state === "complete") || a.begin_us - b.begin_us);
  return film === undefined ? null : { film, from: Math.max(0, (sighting.began_us - film.begin_us) / 1e6 - before) };
}

/** A film that begins a little behind what it is of is still its own (µs): the camera may have held nothing before. */
const CLIP_LATE_US = 3e6;

/** What a key does: the next one, the one before, play or pause, seen or not; null for nothing. */
export function reviewKey(key: string): "next" | "previous" | "play" | "seen" | null {
  switch (key) {
    case "j":
      return "next";
    case "k":
      return "previous";
    case " ":
      return "play";
    case "s":
      return "seen";
    default:
      return null;
  }
}
