/** Outliers as diamonds around their samples: known by shape as well as by colour. */

import { xOf, yOf, type Plot } from "./draw-parts.js";
import type { Palette } from "./palette.js";

/** Half a diamond (CSS pixels). */
const SIZE = 5;
/** Closer than this (CSS pixels) two diamonds would be one. */
const APART = 3;

export interface OutlierPoints {
  readonly times: readonly number[];
  readonly values: readonly number[];
}

export function drawOutliers(plot: Plot, { times, values }: OutlierPoints, palette: Palette): void {
  const { ctx, ratio } = plot;
  const size = SIZE * ratio;
  const path = new Path2D();
  let [lastX, lastY] = [-Infinity, -Infinity];
  for (let i = 0; i < times.length; i += 1) {
    const time = times[i] ?? NaN;
    if (!(time >= plot.span.fromUs && time <= plot.span.toUs)) continue;
    const [x, y] = [xOf(plot, time), yOf(plot, values[i] ?? NaN)];
    if (Math.hypot(x - lastX, y - lastY) < APART * ratio) continue;
    [lastX, lastY] = [x, y];
    path.moveTo(x, y - size);
    path.lineTo(x + size, y);
    path.lineTo(x, y + size);
    path.lineTo(x - size, y);
    path.closePath();
  }
  ctx.save();
  ctx.setLineDash([]);
  ctx.lineJoin = "miter";
  // A rim of the surface's colour, so that it stands out from a line of any colour.
  ctx.strokeStyle = palette.surface;
  ctx.lineWidth = 4 * ratio;
  ctx.stroke(path);
  ctx.strokeStyle = palette.bad;
  ctx.lineWidth = 2 * ratio;
  ctx.stroke(path);
  ctx.restore();
}
