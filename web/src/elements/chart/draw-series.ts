/** All series of a chart on its canvas. */

import { stateWord } from "../../format/state-label.js";
import { summarize } from "../../series/columns.js";
import { stateRuns } from "../../series/state-runs.js";
import type { AxisRange } from "../../series/axis-range.js";
import { panned, type TimeSpan } from "../../series/time-window.js";
import { drawGaps, drawRuns, drawTrace, type Plot, type StateLook } from "./draw-parts.js";
import type { ChartSeries, ChartSamples } from "./chart-model.js";
import { seriesColour, seriesDash, type Palette } from "./palette.js";

/** Least and greatest number in the window; infinities where there is none. */
export function valueExtent(series: readonly ChartSeries[], span: TimeSpan, columnUs: number): { min: number; max: number } {
  let min = Infinity;
  let max = -Infinity;
  const includeSamples = (samples: ChartSamples, seenUs: TimeSpan): void => {
    const seen = summarize(samples.columnsAt(columnUs), seenUs.fromUs, seenUs.toUs);
    min = Math.min(min, seen.min);
    max = Math.max(max, seen.max);
  };
  for (const { samples, states, ghost } of series) {
    if (states.length > 0) continue;
    includeSamples(samples, span);
    if (ghost !== undefined) includeSamples(ghost.samples, panned(span, -ghost.shiftUs));
  }
  return { min, max };
}

/** How a chart's series are drawn. */
export interface DrawOptions {
  readonly palette: Palette;
  /** Time of one pixel column (µs). */
  readonly columnUs: number;
  /** The chart goes with the time: its newest samples are marked, its bands have no outline. */
  readonly moving: boolean;
  /** The value axis of a series. */
  rangeOf(series: ChartSeries): AxisRange;
}

export function drawSeries(plot: Plot, series: readonly ChartSeries[], manner: DrawOptions): void {
  const { palette } = manner;
  // Channels that were lost together were lost once.
  const gaps = new Map(series.flatMap((series) => series.gaps).map((gap) => [`${String(gap.from_us)} ${String(gap.to_us)}`, gap]));
  drawGaps(plot, [...gaps.values()], palette.muted);
  for (const line of series) if (line.states.length > 0) drawStates(plot, line, palette);
  const numbers = series.filter(({ states }) => states.length === 0).map((series) => ({ one: series, own: { ...plot, range: manner.rangeOf(series) } }));
  // What is of another day lies behind all that is of this one.
  for (const { one, own } of numbers) drawGhost(own, one, manner);
  for (const { one, own } of numbers) drawNumbers(own, one, manner);
}

function drawNumbers(plot: Plot, series: ChartSeries, { palette, columnUs, moving }: DrawOptions): void {
  const { samples, stale } = series;
  const colour = stale ? palette.stale : seriesColour(palette, series.colour);
  const dash = stale ? STALE : seriesDash(series.colour);
  drawTrace(plot, samples.columnsAt(columnUs), colour, { dash, dot: moving, outlined: !moving });
}

function drawGhost(plot: Plot, { ghost, colour }: ChartSeries, { palette, columnUs }: DrawOptions): void {
  if (ghost === undefined) return;
  const then: Plot = { ...plot, span: panned(plot.span, -ghost.shiftUs) };
  drawTrace(then, ghost.samples.columnsAt(columnUs), seriesColour(palette, colour), { dash: GHOST, dot: false, outlined: false, faint: FAINT });
}

function drawStates(plot: Plot, series: ChartSeries, palette: Palette): void {
  const { samples, ghost } = series;
  const stateLook = (value: number): StateLook => lookOf(series, value, palette);
  const now = stateRuns(samples.times, samples.values, plot.span.toUs, samples.allowedUs);
  if (ghost === undefined) {
    drawRuns(plot, now, stateLook, palette.text);
    return;
  }
  const height = plot.height * THEN_PART;
  drawRuns({ ...plot, height: plot.height - height }, now, stateLook, palette.text);
  const then: Plot = { ...plot, top: plot.top + plot.height - height, height, span: panned(plot.span, -ghost.shiftUs) };
  drawRuns(then, stateRuns(ghost.samples.times, ghost.samples.values, then.span.toUs, ghost.samples.allowedUs), stateLook, palette.muted);
}

function lookOf(series: ChartSeries, value: number, palette: Palette): StateLook {
  const colour = series.stale ? palette.stale : seriesColour(palette, series.colour + Math.max(0, value));
  return { word: stateWord(series.states, value), colour };
}

/** CSS pixels drawn and left out, in turn. */
const STALE = [5, 4];
const GHOST = [3, 3];
const FAINT = 0.6;
/** The part of a band's height that another day takes. */
const THEN_PART = 0.4;
