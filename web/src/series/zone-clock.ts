/** Days and wall-clock times of a site's own zone. Times are µs since the epoch, UTC. */

import { msg } from "@lit/localize";

export const SECOND_US = 1e6;
export const MINUTE_US = 60 * SECOND_US;
export const HOUR_US = 60 * MINUTE_US;
export const DAY_US = 24 * HOUR_US;
const QUARTER_US = 15 * MINUTE_US;

/** So many offsets are remembered: what the marks of a page of charts take. */
const MOST_QUARTERS = 500;

const WALL = {
  year: "numeric",
  month: "2-digit",
  day: "2-digit",
  hour: "2-digit",
  minute: "2-digit",
  second: "2-digit",
  hourCycle: "h23",
} as const;

/** A zone's clock. Build one and keep it: building takes far longer than using it. */
export class ZoneClock {
  private readonly format: Intl.DateTimeFormat;
  private readonly offsets = new Map<number, number>();

  /** @param zone an IANA name that this browser knows */
  constructor(readonly zone: string) {
    this.format = new Intl.DateTimeFormat("en-GB", { ...WALL, timeZone: zone, era: "short" });
  }

  /** How far the zone is ahead of UTC at a moment (µs). */
  offsetUs(us: number): number {
    // Zones change their offset at full quarters of an hour only, and a chart asks for the same
    // quarter over and over: asking the formatter each time was the dearest part of a live axis.
    const quarter = Math.floor(us / QUARTER_US) * QUARTER_US;
    let offset = this.offsets.get(quarter);
    if (offset === undefined) {
      offset = this.wallUs(quarter) - quarter;
      if (this.offsets.size >= MOST_QUARTERS) this.offsets.clear();
      this.offsets.set(quarter, offset);
    }
    return offset;
  }

  /** Start of the day in which a moment lies. */
  dayStart(us: number): number {
    const wall = us + this.offsetUs(us);
    return this.fromWall(Math.floor(wall / DAY_US) * DAY_US);
  }

  /** Start of the day so many days after (or before) the one in which a moment lies. */
  dayAfter(us: number, days: number): number {
    const wall = us + this.offsetUs(us);
    return this.fromWall((Math.floor(wall / DAY_US) + days) * DAY_US);
  }

  /** The same time by the clock on the wall, so many days later (or before). */
  sameTime(us: number, days: number): number {
    return this.fromWall(us + this.offsetUs(us) + days * DAY_US);
  }

  /**
   * A moment as a field takes it: `2026-03-29 14:05:09`. Browsers' own fields of date and time go by the language
   * of the browser, and would say `02:05 PM` beside charts of 24 hours.
   */
  toInput(us: number): string {
    return new Date((us + this.offsetUs(us)) / 1000).toISOString().slice(0, 19).replace("T", " ");
  }

  /** The moment that such a text means, with `T` or a blank, with or without seconds; NaN when it is empty or no time. */
  fromInput(text: string): number {
    const [, day = "", clock = ""] = /^\s*(\d{4}-\d{2}-\d{2})[T\s]\s*(\d{2}:\d{2}(?::\d{2}(?:\.\d{1,3})?)?)\s*$/.exec(text) ?? [];
    return this.fromWall(Date.parse(`${day}T${clock}Z`) * 1000);
  }

  // A wall-clock time, written as if it were UTC, to its moment. Of a time that the change to
  // summer time skips, the one an hour later; of one that comes twice, the first.
  private fromWall(wall: number): number {
    if (!Number.isFinite(wall)) return NaN;
    const before = wall - this.offsetUs(wall - DAY_US);
    const after = wall - this.offsetUs(wall + DAY_US);
    if (before + this.offsetUs(before) === wall) return before;
    return after + this.offsetUs(after) === wall ? after : before;
  }

  private wallUs(us: number): number {
    const part: Partial<Record<Intl.DateTimeFormatPartTypes, number>> = {};
    for (const { type, value } of this.format.formatToParts(us / 1000)) part[type] = Number(value);
    const { year = 1970, month = 1, day = 1, hour = 0, minute = 0, second = 0 } = part;
    return Date.UTC(year, month - 1, day, hour, minute, second) * 1000;
  }
}

/** What is wrong with a text that should be a moment; empty when nothing is, and when nothing was written. */
export function momentProblem(text: string, us: number): string {
  return text.trim() === "" || !Number.isNaN(us) ? "" : msg("Write it like 2026-03-29 14:05:09.");
}

const clocks = new Map<string, ZoneClock>();

/** The zone's clock, one for all who ask: charts that stand together ask for the same moments. */
export function clockOf(zone: string): ZoneClock {
  let clock = clocks.get(zone);
  if (clock === undefined) {
    clock = new ZoneClock(zone);
    clocks.set(zone, clock);
  }
  return clock;
}
