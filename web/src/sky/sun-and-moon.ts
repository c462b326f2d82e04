/** Sun and Moon, good enough to draw and to plan by: the Sun within 0.02°, the Moon within 0.1°. Pure. */

import { centuries, degrees, toHorizontal, radians, turned, type Equatorial, type Horizontal, type GeoPlace } from "./coordinates.js";

/** The Sun's apparent place; Meeus chapter 25. */
export function sunAt(ms: number): Equatorial {
  const t = centuries(ms);
  const m = radians(357.52911 + 35_999.05029 * t - 0.0001537 * t * t);
  const centre =
    (1.914602 - 0.004817 * t) * Math.sin(m) + (0.019993 - 0.000101 * t) * Math.sin(2 * m) + 0.000289 * Math.sin(3 * m);
  const node = radians(125.04 - 1934.136 * t);
  const longitude = 280.46646 + 36_000.76983 * t + centre - 0.00569 - 0.00478 * Math.sin(node);
  return fromEcliptic(longitude, 0, obliquity(t) + 0.00256 * Math.cos(node));
}

// The greatest terms of Meeus' tables 47.A and 47.B: multiples of D, M, M', F; the last is 1e-6 °.
const LONGITUDE = [
  [0, 0, 1, 0, 6288774], [2, 0, -1, 0, 1274027], [2, 0, 0, 0, 658314], [0, 0, 2, 0, 213618],
  [0, 1, 0, 0, -185116], [0, 0, 0, 2, -114332], [2, 0, -2, 0, 58793], [2, -1, -1, 0, 57066],
  [2, 0, 1, 0, 53322], [2, -1, 0, 0, 45758], [0, 1, -1, 0, -40923], [1, 0, 0, 0, -34720],
  [0, 1, 1, 0, -30383], [2, 0, 0, -2, 15327], [0, 0, 1, 2, -12528], [0, 0, 1, -2, 10980],
] as const;
const LATITUDE = [
  [0, 0, 0, 1, 5128122], [0, 0, 1, 1, 280602], [0, 0, 1, -1, 277693], [2, 0, 0, -1, 173237],
  [2, 0, -1, 1, 55413], [2, 0, -1, -1, 46271], [2, 0, 0, 1, 32573], [0, 0, 2, 1, 17198],
] as const;

/** The Moon as seen from the centre of the Earth; Meeus chapter 47, shortened. */
export function moonAt(ms: number): Equatorial {
  const t = centuries(ms);
  const mean = 218.3164477 + 481_267.88123421 * t;
  const turns = moonArguments(t);
  const longitude = mean + sumOfTerms(LONGITUDE, turns, t);
  return fromEcliptic(longitude, sumOfTerms(LATITUDE, turns, t), obliquity(t));
}

/** Where the Sun stands. */
export function sunFrom(place: GeoPlace, ms: number): Horizontal {
  return toHorizontal(sunAt(ms), place, ms);
}

/** Where the Moon stands, lowered by its parallax of nearly one degree. */
export function moonFrom(place: GeoPlace, ms: number): Horizontal {
  const seen = toHorizontal(moonAt(ms), place, ms);
  const [d, , anomaly] = moonArguments(centuries(ms));
  const parallax = 0.9508 + 0.0518 * Math.cos(radians(anomaly)) + 0.0095 * Math.cos(radians(2 * d - anomaly));
  return { alt: seen.alt - parallax * Math.cos(radians(seen.alt)), az: seen.az };
}

export interface MoonPhase {
  /** How much of the disc is lit, 0 to 1. */
  readonly lit: number;
  readonly waxing: boolean;
}

/** How much of the Moon is lit; Meeus 48.4. */
export function moonPhase(ms: number): MoonPhase {
  const [d, m, anomaly] = moonArguments(centuries(ms));
  const sineOfDegrees = (angle: number): number => Math.sin(radians(angle));
  const i =
    180 - d - 6.289 * sineOfDegrees(anomaly) + 2.1 * sineOfDegrees(m) - 1.274 * sineOfDegrees(2 * d - anomaly) - 0.658 * sineOfDegrees(2 * d) -
    0.214 * sineOfDegrees(2 * anomaly) - 0.11 * sineOfDegrees(d);
  return { lit: (1 + Math.cos(radians(i))) / 2, waxing: turned(d, 360) < 180 };
}

/** Elongation from the Sun, the Sun's anomaly, the Moon's, its distance from the node (°). */
function moonArguments(t: number): readonly [number, number, number, number] {
  return [
    297.8501921 + 445_267.1114034 * t,
    357.5291092 + 35_999.0502909 * t,
    134.9633964 + 477_198.8675055 * t,
    93.272095 + 483_202.0175233 * t,
  ];
}

function sumOfTerms(terms: readonly (readonly number[])[], turns: readonly number[], t: number): number {
  const shape = 1 - 0.002516 * t;
  return terms.reduce((sum, [d = 0, m = 0, anomaly = 0, f = 0, size = 0]) => {
    const angle = d * (turns[0] ?? 0) + m * (turns[1] ?? 0) + anomaly * (turns[2] ?? 0) + f * (turns[3] ?? 0);
    return sum + (size / 1e6) * shape ** Math.abs(m) * Math.sin(radians(angle));
  }, 0);
}

function obliquity(t: number): number {
  return 23.439291 - 0.0130042 * t;
}

function fromEcliptic(longitude: number, latitude: number, obliquity: number): Equatorial {
  const [l, b, e] = [radians(longitude), radians(latitude), radians(obliquity)];
  const ra = Math.atan2(Math.sin(l) * Math.cos(e) - Math.tan(b) * Math.sin(e), Math.cos(l));
  const dec = Math.asin(Math.sin(b) * Math.cos(e) + Math.cos(b) * Math.sin(e) * Math.sin(l));
  return { ra: turned(degrees(ra) / 15, 24), dec: degrees(dec) };
}
