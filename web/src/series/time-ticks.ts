/** Where a time axis has its marks, and what stands at them. */

import { msg } from "@lit/localize";
import { formatClock } from "../format/time.js";
import { DAY_US, HOUR_US, MINUTE_US, SECOND_US, type ZoneClock } from "./zone-clock.js";

const FINE = [1, 2, 5, 10, 20, 50, 100, 200, 500].map((ms) => ms * 1000);
const COARSE = [
  ...[1, 2, 5, 10, 15, 30].map((n) => n * SECOND_US),
  ...[1, 2, 5, 10, 15, 30].map((n) => n * MINUTE_US),
  ...[1, 2, 3, 6, 12].map((n) => n * HOUR_US),
  ...[1, 2, 7, 14, 30, 90, 365].map((n) => n * DAY_US),
];
const STEPS: readonly number[] = [...FINE, ...COARSE];
const LONGEST = 365 * DAY_US;

/** The smallest round step (µs) that gives at most `most` marks in a window. */
export function timeStep(spanUs: number, most: number): number {
  const least = spanUs / Math.max(1, most);
  const found = STEPS.find((step) => step >= least);
  return found ?? Math.ceil(least / LONGEST) * LONGEST;
}

/** Moments of the marks: round times on the wall clock of the zone, in ascending order. */
export function timeTicks(fromUs: number, toUs: number, step: number, clock: ZoneClock): number[] {
  const ticks: number[] = [];
  if (step >= DAY_US) {
    const days = Math.round(step / DAY_US);
    for (let at = clock.dayStart(fromUs); at <= toUs; at = clock.dayAfter(at, days)) if (at >= fromUs) ticks.push(at);
    return ticks;
  }
  // Steps below an hour are round in every zone that is in use, so one offset does for the window;
  // it is also what keeps the marks where they are while a chart scrolls.
  const offset = clock.offsetUs(fromUs);
  for (let at = Math.ceil((fromUs + offset) / step) * step - offset; at <= toUs; at += step) ticks.push(at);
  return ticks;
}

/** What stands at a mark: the clock time, the date at midnight and for steps of days. */
export function tickText(us: number, step: number, clock: ZoneClock): string {
  const intoDay = (us + clock.offsetUs(us)) % DAY_US;
  if (step >= DAY_US || (intoDay === 0 && step >= MINUTE_US)) return shortDate(us, clock);
  const text = formatClock(us, clock.zone);
  if (step >= MINUTE_US) return text.slice(0, 5);
  return step >= SECOND_US ? text : `${text}.${milliseconds(us)}`;
}

function milliseconds(us: number): string {
  return String(Math.floor((us % SECOND_US) / 1000)).padStart(3, "0");
}

const MONTHS = [msg("Jan"), msg("Feb"), msg("Mar"), msg("Apr"), msg("May"), msg("Jun"), msg("Jul"), msg("Aug"), msg("Sep"), msg("Oct"), msg("Nov"), msg("Dec")];

function shortDate(us: number, clock: ZoneClock): string {
  const date = new Date((us + clock.offsetUs(us)) / 1000);
  return `${String(date.getUTCDate())} ${MONTHS[date.getUTCMonth()] ?? ""}`;
}
