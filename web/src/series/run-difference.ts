/** How far two runs of one signal lie apart, sample by sample, with the second put over the first. Pure. */

import { firstIndexFrom } from "./binary-search.js";
import type { TimeSpan } from "./time-window.js";

export interface RunSamples {
  /** µs, rising */
  readonly times: ArrayLike<number>;
  readonly values: ArrayLike<number>;
  /** A longer pause is a gap, over which nothing is known (µs). */
  readonly allowedUs: number;
}

export interface RunDifference {
  /** Root of the mean square of the differences; NaN where the two have no moment in common. */
  readonly rms: number;
  /** First less second, on average. */
  readonly mean: number;
  /** The greatest distance, without its sign. */
  readonly greatest: number;
  /** So many moments were compared. */
  readonly count: number;
}

/**
 * At each sample of the first run in a span the second one is read between its own samples; in its gaps, before and
 * behind it nothing is compared.
 *
 * @param shiftUs the first run's time less the second's (µs)
 */
export function compareRuns(first: RunSamples, second: RunSamples, shiftUs: number, { fromUs, toUs }: TimeSpan): RunDifference {
  let [count, sum, squares, greatest] = [0, 0, 0, 0];
  for (let at = firstIndexFrom(first.times, fromUs); at < first.times.length; at += 1) {
    const us = first.times[at] ?? Infinity;
    if (us > toUs) break;
    const difference = (first.values[at] ?? NaN) - valueBetween(second, us - shiftUs);
    if (!Number.isFinite(difference)) continue;
    count += 1;
    sum += difference;
    squares += difference * difference;
    greatest = Math.max(greatest, Math.abs(difference));
  }
  if (count === 0) return { rms: NaN, mean: NaN, greatest: NaN, count };
  return { rms: Math.sqrt(squares / count), mean: sum / count, greatest, count };
}

function valueBetween({ times, values, allowedUs }: RunSamples, us: number): number {
  const after = firstIndexFrom(times, us);
  const { length } = times;
  const [t1 = NaN, v1 = NaN] = [times[after], values[after]];
  if (after < length && t1 === us) return v1;
  if (after === 0 || after >= length) return NaN;
  const [t0 = NaN, v0 = NaN] = [times[after - 1], values[after - 1]];
  return t1 - t0 > allowedUs ? NaN : v0 + ((v1 - v0) * (us - t0)) / (t1 - t0);
}
