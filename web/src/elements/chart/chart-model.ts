/** What a chart is given to draw. */

import type { Columns } from "../../series/columns.js";
import type { RangeLimits } from "../../series/axis-range.js";
import type { TimeSpan } from "../../series/time-window.js";
import type { GapShape } from "../../generated/api.js";

/** Samples of one channel; `series/trace.ts` is one. */
export interface ChartSamples {
  readonly times: Float64Array;
  readonly values: Float64Array;
  /** Counts up with every change. */
  readonly version: number;
  /** The longest pause that is no gap (µs). */
  readonly allowedUs: number;
  readonly newestUs: number;
  readonly newest: number;
  columnsAt(widthUs: number): Columns;
}

export interface ChartSeries {
  readonly address: string;
  readonly name: string;
  readonly unit: string;
  /** Digits after the point; -1 takes the unit's own. */
  readonly decimals: number;
  /** Place among the eight colours. */
  readonly colour: number;
  readonly samples: ChartSamples;
  /** What each whole number means, for a state; empty for a number. */
  readonly states: readonly string[];
  /** Stretches without samples that have a reason. */
  readonly gaps: readonly GapShape[];
  /** Old values must not look as if they were fresh. */
  readonly stale: boolean;
  /** The same channel at another time, drawn behind. */
  readonly ghost?: GhostSeries;
}

/** Samples of another time, drawn as if they were of this one. */
export interface GhostSeries {
  readonly samples: ChartSamples;
  /** They are drawn so much later than they were taken (µs). */
  readonly shiftUs: number;
}

export interface ChartAxis {
  readonly limits: RangeLimits;
  /** The axis covers at least this much (in the unit). */
  readonly least: number;
}

/** Room at the sides of a plot (CSS pixels). */
export interface ChartIndent {
  readonly left: number;
  readonly right: number;
}

/** Room at a side without an axis (CSS pixels). */
const SIDE = 10;

/** The room that so many value axes take; they stand in turn left and right. */
export function indentOf(axes: number, axisWidth: number): ChartIndent {
  return { left: Math.ceil(axes / 2) * axisWidth || SIDE, right: Math.floor(axes / 2) * axisWidth || SIDE };
}

/** Gives the window at this moment; for a chart that moves with the time. */
export type FollowWindow = (nowMs: number) => TimeSpan;

/** Detail of `t-span`. */
export interface SpanChange {
  readonly span: TimeSpan;
  /** False while fingers or wheel are still at it. */
  readonly settled: boolean;
}

/** A value at the cursor. */
export interface CursorValue {
  readonly series: ChartSeries;
  /** When the sample was taken; NaN when there is none near. */
  readonly timeUs: number;
  readonly text: string;
}
