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
}

/** Closer than this to the point before adds nothing to a drawn trail (m). */
const CLOSER_ADDS_NOTHING = 0.01;
/** So that a trail can not grow without end. */
export const MOST_POINTS = 8000;

/** Two channels of one position, joined where both have a number at the same moment. */
export function joinTrack(x: PointSeries, y: PointSeries): TrackPoint[] {
  const points: TrackPoint[] = [];
  let j = 0;
  for (let i = 0; i < x.t_us.length; i++) {
    const timeUs = x.t_us[i] ?? 0;
    while (j < y.t_us.length && (y.t_us[j] ?? 0) < timeUs) j++;
    const [first, second] = [x.v[i], y.v[j]];
    if (y.t_us[j] !== timeUs || typeof first !== "number" || typeof second !== "number") continue;
    points.push({ x: first, y: second, timeUs });
  }
  return points;
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
export function backfill(history: readonly TrackPoint[], live: readonly TrackPoint[]): TrackPoint[] {
  const first = live[0]?.timeUs ?? Number.POSITIVE_INFINITY;
  return [...history.filter((point) => point.timeUs < first), ...live].slice(-MOST_POINTS);
}

/** A place in degrees, WGS 84. */
export interface Place {
  readonly lat: number;
  readonly lon: number;
}

const METRES_PER_DEGREE = 111_195;

/** East and north of an origin (m), on a plane that touches there: good for some kilometres. */
export function flat(place: Place, origin: Place): { readonly x: number; readonly y: number } {
  // The short way round at the antimeridian.
  const east = ((((place.lon - origin.lon + 540) % 360) + 360) % 360) - 180;
  return {
    x: east * METRES_PER_DEGREE * Math.cos((origin.lat * Math.PI) / 180),
    y: (place.lat - origin.lat) * METRES_PER_DEGREE,
  };
}

/** Which way the last stretch of at least `least` metres went (rad, as in REP-103); NaN: none. */
export function course(track: readonly TrackPoint[], least = 0.3): number {
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
