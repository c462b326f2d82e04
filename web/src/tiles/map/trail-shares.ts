/** A trail coloured by a signal: which value held at each of its moments, on a scale from 0 to 1. Pure. */

import type { TrailPoint } from "../../elements/map/geo-painter.js";
import { placeOfFlat, placeOfLocal, type MapFrame, type MapPlace } from "../../elements/map/geodesy.js";
import { isBreak, type TrackPoint } from "../../elements/map/track.js";

export interface SignalSample {
  readonly timeUs: number;
  readonly value: number;
}

/** A value says nothing about moments that are farther from it than this (µs). */
const HOLDS_US = 10e6;

export interface ShareScale {
  readonly least: number;
  readonly most: number;
}

/** By the limits that a description gives, else by what was seen; null before anything was. */
export function scaleOf(samples: readonly SignalSample[], least: number | null, most: number | null): ShareScale | null {
  let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
  for (const { value } of samples) {
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  const scale = { least: least ?? low, most: most ?? high };
  return scale.least < scale.most && Number.isFinite(scale.least) && Number.isFinite(scale.most) ? scale : null;
}

/** The share of each moment: of the last sample at or before it. Both are in the order of time. */
export function sharesAt(times: readonly number[], samples: readonly SignalSample[], scale: ShareScale | null): number[] {
  let at = -1;
  return times.map((timeUs) => {
    while (at + 1 < samples.length && (samples[at + 1]?.timeUs ?? 0) <= timeUs) at++;
    const sample = samples[at];
    if (scale === null || sample === undefined || timeUs - sample.timeUs > HOLDS_US) return Number.NaN;
    return Math.max(0, Math.min(1, (sample.value - scale.least) / (scale.most - scale.least)));
  });
}

/** A trail on Earth. `frame` with a heading is a robot's own; without, the plane at the first fix. */
export function trailOnEarth(track: readonly TrackPoint[], frame: MapFrame | MapPlace, shares: readonly number[]): TrailPoint[] {
  return track.map((point, i) => {
    const before = track[i - 1];
    const place = "heading" in frame ? placeOfLocal(point, frame) : placeOfFlat(point, frame);
    return { ...place, timeUs: point.timeUs, share: shares[i] ?? Number.NaN, apart: before !== undefined && isBreak(before, point) };
  });
}
