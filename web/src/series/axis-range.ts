/** The lower and upper end of a value axis. */

export interface AxisRange {
  readonly low: number;
  readonly high: number;
}

/** What is known of a signal besides its samples. */
export interface RangeLimits {
  readonly minimum: number | null;
  readonly maximum: number | null;
}

export const NO_LIMITS: RangeLimits = { minimum: null, maximum: null };

const PADDING = 0.06;
/** What the axis covers when all data are one value (a share of it), and when all are zero. */
const FLAT = 0.02;
const FLAT_ZERO = 0.5;
const MOST_DECIMALS = 9;
/** While the data fill at least this much of the axis, the axis stays as it is. */
const WORTH = 0.4;

/**
 * The axis for data between `min` and `max`: round ends, a little air, and the signal's own limits
 * where there are any (data beyond a limit are shown all the same).
 *
 * @param least the axis covers at least this much, so that noise in the last digit stays small
 */
export function niceRange(min: number, max: number, limits: RangeLimits = NO_LIMITS, least = 0): AxisRange {
  const low = Math.min(min, limits.minimum ?? Infinity);
  const high = Math.max(max, limits.maximum ?? -Infinity);
  if (!(low <= high)) return fallbackRange(limits);
  const flat = high === low ? Math.abs(high) * FLAT || FLAT_ZERO : 0;
  const size = Math.max(high - low, least, flat, Math.abs(high) * 1e-9);
  const middle = (low + high) / 2;
  const air = size * PADDING;
  const from = size > high - low ? middle - size / 2 - air : low - air;
  const to = size > high - low ? middle + size / 2 + air : high + air;
  const step = niceStep((to - from) / 4) / 2;
  return {
    low: limits.minimum !== null && min >= limits.minimum ? limits.minimum : Math.floor(from / step) * step,
    high: limits.maximum !== null && max <= limits.maximum ? limits.maximum : Math.ceil(to / step) * step,
  };
}

/** The round number (1, 2 or 5 times a power of ten) that is not below `size`. */
export function niceStep(size: number): number {
  if (!(size > 0) || !Number.isFinite(size)) return 1;
  const power = 10 ** Math.floor(Math.log10(size));
  for (const factor of [1, 2, 5]) if (factor * power >= size * (1 - 1e-12)) return factor * power;
  return 10 * power;
}

/** Digits after the point that marks with this step need: 2 for 0.25. */
export function decimalsOf(step: number): number {
  for (let decimals = 0; decimals < MOST_DECIMALS; decimals += 1) {
    const scaled = step * 10 ** decimals;
    if (Math.abs(scaled - Math.round(scaled)) < 1e-6 * scaled) return decimals;
  }
  return MOST_DECIMALS;
}

/** Keeps an axis still while it still fits, so that it does not jump with every sample. */
export class SteadyRange {
  private held: AxisRange | null = null;

  constructor(
    private readonly limits: RangeLimits = NO_LIMITS,
    private readonly least = 0,
  ) {}

  nextRange(min: number, max: number): AxisRange {
    const fresh = niceRange(min, max, this.limits, this.least);
    const held = this.held;
    if (held === null || min < held.low || max > held.high || !(min <= max)) return (this.held = fresh);
    if (fresh.high - fresh.low < WORTH * (held.high - held.low)) return (this.held = fresh);
    return held;
  }
}

function fallbackRange(limits: RangeLimits): AxisRange {
  const low = limits.minimum ?? (limits.maximum === null ? 0 : limits.maximum - 1);
  return { low, high: limits.maximum ?? low + 1 };
}
