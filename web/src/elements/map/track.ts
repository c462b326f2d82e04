/** A position over time: joined from its channels, thinned, and put on a flat local plane. */

export interface TrackPoint {
  /** m, east or forward */
  readonly x: number;
  /** m, north or left */
  readonly y: number;
  /** µs since the epoch */
  readonly timeUs: number;
}

/** A series as the hub's history gives it. */
export interface PointSeries {
  readonly t_us: readonly number[];
  readonly v: readonly (number | null)[];
  readonly kind?: "exact" | "minmax";
}

/** Closer than this to the point before adds nothing to a drawn trail (m). */
const CLOSER_ADDS_NOTHING = 0.01;
/** So that a trail can not grow without end. */
export const MOST_POINTS = 8000;

/** Readings farther apart than this have nothing to say about the time between (µs). */
const APART_US = 10e6;

interface TrackReading {
  readonly timeUs: number;
  readonly value: number;
}

/** The numbers of a series; of least and greatest in a bucket, what lies between them. */
function readingsOf(series: PointSeries): TrackReading[] {
  const all = series.t_us.flatMap((timeUs, i) => {
    const value = series.v[i];
    return typeof value === "number" ? [{ timeUs, value }] : [];
  });
  if (series.kind !== "minmax") return all;
  const middles: TrackReading[] = [];
  for (let i = 0; i + 1 < all.length; i += 2) {
    const [a, b] = [all[i], all[i + 1]];
    if (a && b) middles.push({ timeUs: (a.timeUs + b.timeUs) / 2, value: (a.value + b.value) / 2 });
  }
  return middles;
}

/** Two channels of one position, joined at the moments of the first. */
export function joinTrack(x: PointSeries, y: PointSeries): TrackPoint[] {
  const [across, up] = [readingsOf(x), readingsOf(y)];
  let j = 0;
  return across.flatMap(({ timeUs, value }) => {
    while (j + 1 < up.length && (up[j + 1]?.timeUs ?? 0) <= timeUs) j++;
    const between = interpolatedAt(timeUs, up[j], up[j + 1]);
    return between === null ? [] : [{ x: value, y: between, timeUs }];
  });
}

function interpolatedAt(timeUs: number, before: TrackReading | undefined, after: TrackReading | undefined): number | null {
  if (!before || before.timeUs > timeUs) return null;
  if (before.timeUs === timeUs) return before.value;
  if (!after || after.timeUs - before.timeUs > APART_US) return null;
  const share = (timeUs - before.timeUs) / (after.timeUs - before.timeUs);
  return before.value + share * (after.value - before.value);
}

/** Nothing is known of the way from one point to the next: no line is drawn. */
export function isBreak(from: TrackPoint, to: TrackPoint): boolean {
  return to.timeUs - from.timeUs > APART_US && Math.hypot(to.x - from.x, to.y - from.y) > 0.5;
}

/** Adds a newer point, unless it lies where the last one does, and forgets what is too old. */
export function extendTrack(track: readonly TrackPoint[], point: TrackPoint, keepUs: number): TrackPoint[] {
  const last = track.at(-1);
  if (last && point.timeUs <= last.timeUs) return [...track];
  const kept = track.filter((old) => point.timeUs - old.timeUs <= keepUs);
  const near = last && Math.hypot(point.x - last.x, point.y - last.y) < CLOSER_ADDS_NOTHING;
  if (!near) kept.push(point);
  return kept.slice(-MOST_POINTS);
}

/** What came live, after what the history knew of the time before it. */
export function mergeTracks(history: readonly TrackPoint[], live: readonly TrackPoint[]): TrackPoint[] {
  const first = live[0]?.timeUs ?? Number.POSITIVE_INFINITY;
  return [...history.filter((point) => point.timeUs < first), ...live].slice(-MOST_POINTS);
}

/** Which way the last stretch of at least `least` metres went (rad, as in REP-103); NaN: none. */
export function courseOf(track: readonly TrackPoint[], least = 0.3): number {
  const last = track.at(-1);
  if (!last) return Number.NaN;
  for (let i = track.length - 2; i >= 0; i--) {
    const point = track[i];
    if (point && Math.hypot(last.x - point.x, last.y - point.y) >= least) {
      return Math.atan2(last.y - point.y, last.x - point.x);
    }
  }
  return Number.NaN;
}

/** 1, 2 or 5 times a power of ten: the smallest such length of at least `least`. */
export function niceLength(least: number): number {
  if (!(least > 0) || !Number.isFinite(least)) return 1;
  const exponent = Math.floor(Math.log10(least));
  for (const step of [1, 2, 5]) {
    // By its decimal form: 2 * 10 ** -1 is not what is written as 0.2 for every exponent.
    const length = Number(`${String(step)}e${String(exponent)}`);
    if (length >= least * 0.999999) return length;
  }
  return Number(`1e${String(exponent + 1)}`);
}

/** `20 cm`, `5 m`, `2 km` */
export function formatLength(metres: number): string {
  if (metres < 1) return `${String(Math.round(metres * 100))}\u202fcm`;
  if (metres < 1000) return `${String(Math.round(metres))}\u202fm`;
  return `${String(Math.round(metres / 100) / 10)}\u202fkm`;
}
