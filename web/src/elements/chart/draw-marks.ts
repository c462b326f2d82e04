/** Thin lines where something happened; what it was is said beside the chart. */

import type { Palette } from "./palette.js";
import { xOf, yOf, type Plot } from "./draw-parts.js";

export interface ChartMark {
  /** µs since the epoch, UTC */
  readonly timeUs: number;
  readonly good: boolean;
  /** It lasted until then, or goes on (Infinity): the stretch is shaded. */
  readonly untilUs?: number;
}

const APART = 2;
const DASH = [2, 3];
const LEVEL = [5, 4];
const ALPHA = 0.55;
const SHADE = 0.16;

export function drawMarks(plot: Plot, marks: readonly ChartMark[], palette: Palette): void {
  const { ctx, ratio, top, height } = plot;
  let last = -Infinity;
  ctx.save();
  ctx.globalAlpha = ALPHA;
  ctx.lineWidth = ratio;
  ctx.setLineDash(DASH.map((pixels) => pixels * ratio));
  for (const mark of marks) drawStretch(plot, mark, palette);
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

function drawStretch(plot: Plot, { timeUs, untilUs, good }: ChartMark, palette: Palette): void {
  if (untilUs === undefined || untilUs < plot.span.fromUs || timeUs > plot.span.toUs) return;
  const { ctx, top, height } = plot;
  const [from, to] = [xOf(plot, Math.max(timeUs, plot.span.fromUs)), xOf(plot, Math.min(untilUs, plot.span.toUs))];
  ctx.save();
  ctx.globalAlpha = SHADE;
  ctx.fillStyle = good ? palette.muted : palette.bad;
  ctx.fillRect(from, top, to - from, height);
  ctx.restore();
}

/** A dashed line across, at a value of the plot's own axis. */
export function drawLevel(plot: Plot, value: number, palette: Palette): void {
  const { ctx, ratio, left, width } = plot;
  const y = Math.round(yOf(plot, value)) + 0.5;
  ctx.save();
  ctx.strokeStyle = palette.bad;
  ctx.lineWidth = ratio;
  ctx.setLineDash(LEVEL.map((pixels) => pixels * ratio));
  ctx.beginPath();
  ctx.moveTo(left, y);
  ctx.lineTo(left + width, y);
  ctx.stroke();
  ctx.restore();
}
