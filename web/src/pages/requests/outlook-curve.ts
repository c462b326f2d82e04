/** A night as the hub worked it out, as the chart of a night draws it. Pure. */

import type { SkyCurveShape } from "../../generated/api.js";
import type { SkySpan } from "../../sky/night-sky.js";
import { bandsOf, type NightTrack, type Visibility } from "../../sky/night-visibility.js";

export interface CurveNight {
  readonly night: NightTrack;
  readonly seen: Visibility;
  /** Altitude of the Moon at each point (°). */
  readonly moon: readonly number[];
  /** While it may be observed (ms). */
  readonly allowed: readonly SkySpan[];
}

/** Null for a curve without a stretch of time. */
export function curveNight(curve: SkyCurveShape): CurveNight | null {
  const points = curve.times_us.map((us, i) => ({ ms: us / 1000, alt: curve.altitude[i] ?? Number.NaN, sun: curve.sun_altitude[i] ?? Number.NaN }));
  const [first, last] = [points[0], points.at(-1)];
  if (first === undefined || last === undefined || last.ms <= first.ms) return null;
  const allowed = spansOf(points.map(({ ms }, i) => ({ ms, allowed: curve.allowed[i] ?? false })));
  const open = points.filter((_, i) => curve.allowed[i] === true);
  const best = open.length === 0 ? undefined : open.reduce((high, point) => (point.alt > high.alt ? point : high));
  const alts = points.map(({ alt }) => alt);
  return {
    night: { from: first.ms, to: last.ms, points, bands: bandsOf(points) },
    seen: {
      seen: best !== undefined, best: best?.alt ?? Number.NaN, bestMs: best?.ms ?? Number.NaN, highest: Math.max(...alts), lowest: Math.min(...alts),
      fromMs: allowed[0]?.from ?? Number.NaN, toMs: allowed.at(-1)?.to ?? Number.NaN,
    },
    moon: curve.moon_altitude,
    allowed,
  };
}

/** Each stretch of moments that are allowed, to the first that is not. */
function spansOf(moments: readonly { readonly ms: number; readonly allowed: boolean }[]): SkySpan[] {
  const spans: SkySpan[] = [];
  let from = Number.NaN;
  for (const { ms, allowed } of moments) {
    if (allowed && Number.isNaN(from)) from = ms;
    if (!allowed && !Number.isNaN(from)) {
      spans.push({ from, to: ms });
      from = Number.NaN;
    }
  }
  const end = moments.at(-1)?.ms ?? Number.NaN;
  if (end > from) spans.push({ from, to: end });
  return spans;
}
