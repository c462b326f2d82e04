/** Series of the hub's history as a chart holds them. */

import { typicalInterval } from "../../series/gaps.js";
import type { GapShape, SeriesShape } from "../../generated/api.js";

export interface PastSamples {
  readonly times: Float64Array;
  readonly values: Float64Array;
  /** The usual time between readings (µs). */
  readonly intervalUs: number;
}

/** Ascending times and values; "not a number" stands where a gap begins, so that no line or state goes on across. */
export function samplesOf(series: SeriesShape): PastSamples {
  return joinSeries([series]);
}

/** The same of one channel's stretches that follow one another. */
export function joinSeries(parts: readonly SeriesShape[]): PastSamples {
  const samples = sorted(concatenated(parts));
  const typical = typicalInterval(samples.times);
  const breaks = gapsOfParts(parts).map(({ from_us: fromUs }) => fromUs + 1).sort((a, b) => a - b);
  return {
    ...withBreaks(samples, breaks),
    // Two points stand for each pixel, anywhere within it: their usual interval is half a pixel.
    intervalUs: parts.some(({ kind }) => kind === "minmax") ? 2 * typical : typical,
  };
}

/** Each gap once: one that lasts longer than a stretch is told with each that it touches. */
export function gapsOfParts(parts: readonly SeriesShape[]): GapShape[] {
  const found = new Map<string, GapShape>();
  for (const { gaps } of parts) for (const gap of gaps) found.set(`${String(gap.from_us)} ${String(gap.to_us)} ${gap.reason}`, gap);
  return [...found.values()];
}

type Samples = Pick<PastSamples, "times" | "values">;

// A moment of a board brings tens of thousands of samples: loops over arrays of numbers, no object for each.

function concatenated(parts: readonly SeriesShape[]): Samples {
  const size = parts.reduce((sum, { t_us }) => sum + t_us.length, 0);
  const times = new Float64Array(size);
  const values = new Float64Array(size);
  let at = 0;
  for (const { t_us, v } of parts) {
    times.set(t_us, at);
    for (let i = 0; i < t_us.length; i += 1) values[at + i] = v[i] ?? NaN;
    at += t_us.length;
  }
  return { times, values };
}

function sorted({ times, values }: Samples): Samples {
  let i = 1;
  while (i < times.length && !((times[i] ?? NaN) < (times[i - 1] ?? NaN))) i += 1;
  if (i >= times.length) return { times, values };
  const order = [...times.keys()].sort((a, b) => (times[a] ?? NaN) - (times[b] ?? NaN));
  return { times: Float64Array.from(order, (from) => times[from] ?? NaN), values: Float64Array.from(order, (from) => values[from] ?? NaN) };
}

/** @param breaks times, ascending; behind a sample of the same time */
function withBreaks({ times, values }: Samples, breaks: readonly number[]): Samples {
  if (breaks.length === 0) return { times, values };
  const broken = { times: new Float64Array(times.length + breaks.length), values: new Float64Array(times.length + breaks.length) };
  let [at, next] = [0, 0];
  const append = (timeUs: number, value: number): void => {
    broken.times[at] = timeUs;
    broken.values[at] = value;
    at += 1;
  };
  for (let i = 0; i < times.length; i += 1) {
    const timeUs = times[i] ?? NaN;
    for (; next < breaks.length && (breaks[next] ?? NaN) < timeUs; next += 1) append(breaks[next] ?? NaN, NaN);
    append(timeUs, values[i] ?? NaN);
  }
  for (; next < breaks.length; next += 1) append(breaks[next] ?? NaN, NaN);
  return broken;
}
