/** All series of a chart on its canvas. */

import { stateWord } from "../../format/reading.js";
import { summary } from "../../series/columns.js";
import { runs } from "../../series/runs.js";
import type { Span } from "../../series/window.js";
import { drawGaps, drawRuns, drawTrace, type Plot, type StateLook } from "./draw.js";
import type { ChartSeries } from "./model.js";
import { seriesColour, type Palette } from "./palette.js";

/** Least and greatest number in the window; infinities where there is none. */
export function extent(series: readonly ChartSeries[], span: Span, columnUs: number): { min: number; max: number } {
  let min = Infinity;
  let max = -Infinity;
  for (const { samples, states } of series) {
    if (states.length > 0) continue;
    const seen = summary(samples.columnsAt(columnUs), span.fromUs, span.toUs);
    min = Math.min(min, seen.min);
    max = Math.max(max, seen.max);
  }
  return { min, max };
}

/** @param moving the chart goes with the time: its newest samples are marked, its bands have no outline */
export function drawSeries(plot: Plot, series: readonly ChartSeries[], palette: Palette, columnUs: number, moving: boolean): void {
  // Channels that were lost together were lost once.
  const gaps = new Map(series.flatMap((one) => one.gaps).map((gap) => [`${String(gap.from_us)} ${String(gap.to_us)}`, gap]));
  drawGaps(plot, [...gaps.values()], palette.muted);
  for (const one of series) {
    const { samples, stale } = one;
    if (one.states.length > 0) {
      const found = runs(samples.times, samples.values, plot.span.toUs, samples.allowedUs);
      drawRuns(plot, found, (value) => lookOf(one, value, palette), palette.text);
    } else {
      const colour = stale ? palette.stale : seriesColour(palette, one.colour);
      drawTrace(plot, samples.columnsAt(columnUs), colour, { dashed: stale, dot: moving, outlined: !moving });
    }
  }
}

function lookOf(series: ChartSeries, value: number, palette: Palette): StateLook {
  const colour = series.stale ? palette.stale : seriesColour(palette, series.colour + Math.max(0, value));
  return { word: stateWord(series.states, value), colour };
}
