/**
 * Outliers by the interquartile range: samples more than `k` times the distance of the quartiles
 * below the first or above the third. With `k` 1.5 these are Tukey's fences.
 */

import type { TimeSpan } from "./time-window.js";

/** Tukey's. */
export const USUAL_K = 1.5;
export const LEAST_K = 0.5;
export const MOST_K = 10;
/** Of fewer samples quartiles say nothing. */
const LEAST = 8;

export interface Outliers {
  /** Samples in the window, all of them numbers. */
  readonly samples: number;
  readonly count: number;
  /** What lies between these is no outlier; NaN of too few samples. */
  readonly low: number;
  readonly high: number;
  readonly times: readonly number[];
  readonly values: readonly number[];
}

/** The value that a part (0 to 1) of sorted values lies below, between neighbours by share. */
export function quantile(sorted: ArrayLike<number>, part: number): number {
  const place = (sorted.length - 1) * part;
  const low = sorted[Math.floor(place)] ?? NaN;
  const high = sorted[Math.ceil(place)] ?? NaN;
  return low + (high - low) * (place - Math.floor(place));
}

export function outliersOf(times: ArrayLike<number>, values: ArrayLike<number>, span: TimeSpan, k: number): Outliers {
  const places: number[] = [];
  for (let i = 0; i < times.length; i += 1) {
    const time = times[i] ?? NaN;
    if (time >= span.fromUs && time <= span.toUs && Number.isFinite(values[i])) places.push(i);
  }
  const samples = places.length;
  if (samples < LEAST) return { samples, count: 0, low: NaN, high: NaN, times: [], values: [] };
  const sorted = Float64Array.from(places, (i) => values[i] ?? NaN).sort();
  const [first, third] = [quantile(sorted, 0.25), quantile(sorted, 0.75)];
  const [low, high] = [first - k * (third - first), third + k * (third - first)];
  const out = places.filter((i) => (values[i] ?? NaN) < low || (values[i] ?? NaN) > high);
  return { samples, count: out.length, low, high, times: out.map((i) => times[i] ?? NaN), values: out.map((i) => values[i] ?? NaN) };
}

/** What the hub found in all samples of a window; see `OutlierShape`. */
export interface OutlierFences {
  readonly samples: number;
  readonly count: number;
  readonly low: number | null;
  readonly high: number | null;
}

/** Points on a chart that lie beyond fences; counted are the samples that the hub has counted. */
export function outliersBeyond(times: ArrayLike<number>, values: ArrayLike<number>, span: TimeSpan, fences: OutlierFences): Outliers {
  const { samples, count } = fences;
  const [low, high] = [fences.low ?? NaN, fences.high ?? NaN];
  const places: number[] = [];
  for (let i = 0; i < times.length; i += 1) {
    const [time, value] = [times[i] ?? NaN, values[i] ?? NaN];
    if (time >= span.fromUs && time <= span.toUs && Number.isFinite(value) && (value < low || value > high)) places.push(i);
  }
  return { samples, count, low, high, times: places.map((i) => times[i] ?? NaN), values: places.map((i) => values[i] ?? NaN) };
}

/** What the outliers of one channel were found in; the same again costs nothing. */
interface OutlierQuery {
  readonly of: object;
  readonly version: number;
  readonly span: TimeSpan;
  readonly by: number | OutlierFences;
}

/** Keeps the last answer for as long as the question is the same. */
export class OutlierMemo {
  private asked: OutlierQuery | null = null;
  private found: Outliers | null = null;

  /** @param by so many times the distance of the samples' own quartiles, or fences that are known */
  outliersOf(samples: { readonly times: ArrayLike<number>; readonly values: ArrayLike<number>; readonly version: number }, span: TimeSpan, by: number | OutlierFences): Outliers {
    const { asked, found } = this;
    const same =
      asked?.of === samples &&
      asked.version === samples.version &&
      asked.by === by &&
      asked.span.fromUs === span.fromUs &&
      asked.span.toUs === span.toUs;
    if (same && found !== null) return found;
    this.asked = { of: samples, version: samples.version, span, by };
    this.found = typeof by === "number" ? outliersOf(samples.times, samples.values, span, by) : outliersBeyond(samples.times, samples.values, span, by);
    return this.found;
  }
}
