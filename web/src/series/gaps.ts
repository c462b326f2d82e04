/** Where a channel was silent for longer than it should be. */

import type { GapShape } from "../generated/api.js";

const OFTEN = 3;
const REMEMBERED = 31;

/** The longest pause that is no gap (µs): three usual intervals, and never less than the limit of age. */
export function pauseAllowed(intervalUs: number, maxAgeUs: number): number {
  return Math.max(Number.isFinite(intervalUs) ? OFTEN * intervalUs : 0, maxAgeUs);
}

/** The usual time between samples (µs): the median, so that one outage does not hide the next. */
export function typicalInterval(times: ArrayLike<number>): number {
  const between: number[] = [];
  // A long series is sampled: a few hundred intervals tell the median as well as all do.
  const step = Math.max(1, Math.floor(times.length / 256));
  for (let i = 1; i < times.length; i += step) {
    const pause = (times[i] ?? NaN) - (times[i - 1] ?? NaN);
    if (pause > 0) between.push(pause);
  }
  return median(between);
}

/** Follows the usual interval of a channel as its samples come. */
export class IntervalWatch {
  private readonly recent: number[] = [];
  private next = 0;
  private typical = NaN;
  private last = NaN;

  get typicalUs(): number {
    return this.typical;
  }

  addTime(timeUs: number): void {
    const pause = timeUs - this.last;
    this.last = timeUs;
    if (!(pause > 0)) return;
    this.recent[this.next % REMEMBERED] = pause;
    this.next += 1;
    // The median is taken now and then only: it moves slowly, and sorting is the dear part.
    if (this.next < REMEMBERED || this.next % 16 === 0) this.typical = median(this.recent);
  }

  /** Believe this interval until samples have come to tell a better one. */
  assumeInterval(intervalUs: number): void {
    if (Number.isNaN(this.typical)) this.typical = intervalUs;
  }

  /** Go on from where another has come to. */
  continueFrom(other: IntervalWatch): void {
    this.recent.splice(0, Infinity, ...other.recent);
    this.next = other.next;
    this.typical = other.typical;
    this.last = other.last;
  }
}

/** The pauses that are longer than `allowedUs`. */
export function gapsOf(times: ArrayLike<number>, allowedUs: number): GapShape[] {
  const found: GapShape[] = [];
  for (let i = 1; i < times.length; i += 1) {
    const from_us = times[i - 1] ?? NaN;
    const to_us = times[i] ?? NaN;
    if (to_us - from_us > allowedUs) found.push({ from_us, to_us, reason: "" });
  }
  return found;
}

function median(numbers: readonly number[]): number {
  const sorted = [...numbers].sort((a, b) => a - b);
  return sorted[sorted.length >>> 1] ?? NaN;
}
