/** Thin lines where something happened; what it was is said beside the chart. */

import type { Palette } from "./palette.js";
import { xOf, type Plot } from "./draw.js";

export interface ChartMark {
  /** µs since the epoch, UTC */
  readonly timeUs: number;
  readonly good: boolean;
}

const APART = 2;
const DASH = [2, 3];
const ALPHA = 0.55;

export function drawMarks(plot: Plot, marks: readonly ChartMark[], palette: Palette): void {
  const { ctx, ratio, top, height } = plot;
  let last = -Infinity;
  ctx.save();
  ctx.globalAlpha = ALPHA;
  ctx.lineWidth = ratio;
  ctx.setLineDash(DASH.map((pixels) => pixels * ratio));
  for (const { timeUs, good } of marks) {
    if (timeUs < plot.span.fromUs || timeUs > plot.span.toUs) continue;
    const x = Math.round(xOf(plot, timeUs)) + 0.5;
    // Of several in one place one is seen, but one that was bad always is.
    if (x - last < APART * ratio && good) continue;
    last = x;
    ctx.strokeStyle = good ? palette.text : palette.bad;
    ctx.beginPath();
    ctx.moveTo(x, top);
    ctx.lineTo(x, top + height);
    ctx.stroke();
  }
  ctx.restore();
}
