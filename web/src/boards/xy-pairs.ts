/** Two channels as points of a plane: the second at each moment of the first. Pure. */

export interface XyPoint {
  readonly x: number;
  readonly y: number;
}

interface SampleColumns {
  readonly times: ArrayLike<number>;
  readonly values: ArrayLike<number>;
}

/** So many points are drawn at most: evenly among those that there are. */
const MOST = 1500;

/**
 * For each sample of `across` since `fromUs` the last one of `upwards` before it, unless that is older
 * than `allowedUs`: what was not known at a moment is no point.
 */
export function xyPairs(across: SampleColumns, upwards: SampleColumns, fromUs: number, allowedUs: number): readonly XyPoint[] {
  const points: XyPoint[] = [];
  let held = -1;
  for (let i = 0; i < across.times.length; i += 1) {
    const at = across.times[i] ?? Number.NaN;
    while (held + 1 < upwards.times.length && (upwards.times[held + 1] ?? Infinity) <= at) held += 1;
    const x = across.values[i] ?? Number.NaN;
    const y = upwards.values[held] ?? Number.NaN;
    const known = at >= fromUs && held >= 0 && at - (upwards.times[held] ?? 0) <= allowedUs;
    if (known && Number.isFinite(x) && Number.isFinite(y)) points.push({ x, y });
  }
  const step = Math.ceil(points.length / MOST);
  // Counted from the newest, which is always drawn.
  return step <= 1 ? points : points.filter((_point, i) => (points.length - 1 - i) % step === 0);
}

/** Least and greatest with a tenth of room; of values that stay the same one to each side. */
export function roomFor(values: readonly number[]): readonly [low: number, high: number] {
  if (values.length === 0) return [0, 1];
  const low = Math.min(...values);
  const high = Math.max(...values);
  const room = high > low ? (high - low) / 10 : 1;
  return [low - room, high + room];
}
