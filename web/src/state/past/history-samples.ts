/** A series of the hub's history as a chart holds it. */

import { typicalInterval } from "../../series/gaps.js";
import type { SeriesShape } from "../../generated/api.js";

export interface PastSamples {
  readonly times: Float64Array;
  readonly values: Float64Array;
  /** The usual time between readings (µs). */
  readonly intervalUs: number;
}

/** Ascending times and values; "not a number" stands where a gap begins, so that no line or state goes on across. */
export function samplesOf(series: SeriesShape): PastSamples {
  const points = series.t_us.map((timeUs, i) => ({ timeUs, value: series.v[i] ?? NaN }));
  const typical = typicalInterval([...series.t_us].sort((a, b) => a - b));
  for (const gap of series.gaps) points.push({ timeUs: gap.from_us + 1, value: NaN });
  points.sort((a, b) => a.timeUs - b.timeUs);
  return {
    times: Float64Array.from(points, ({ timeUs }) => timeUs),
    values: Float64Array.from(points, ({ value }) => value),
    // Two points stand for each pixel, anywhere within it: their usual interval is half a pixel.
    intervalUs: series.kind === "minmax" ? 2 * typical : typical,
  };
}
