/**
 * Where things stand in the sky: sidereal time, horizon coordinates, precession. Pure.
 *
 * Formulas from J. Meeus, Astronomical Algorithms, 2nd edition (chapters 12, 13, 17, 21). Angles in
 * degrees, right ascension in hours, azimuth from north through east, longitude positive to the
 * east. Refraction, nutation and aberration are left out: half an arc minute above 30° of altitude.
 */

import { wrapped } from "../format/sexagesimal.js";

export { wrapped as turned };

const J2000 = 2_451_545.0;
const DAY_MS = 86_400_000;

/** A place on Earth: degrees north, degrees east. */
export interface GeoPlace {
  readonly latitude: number;
  readonly longitude: number;
}

/** A direction among the stars: right ascension (h) and declination (°). */
export interface Equatorial {
  readonly ra: number;
  readonly dec: number;
}

/** A direction from a place: altitude above the horizon and azimuth (°). */
export interface Horizontal {
  readonly alt: number;
  readonly az: number;
}

export const radians = (degrees: number): number => (degrees * Math.PI) / 180;
export const degrees = (angle: number): number => (angle * 180) / Math.PI;
const clampedUnit = (value: number): number => Math.max(-1, Math.min(1, value));

/** @param ms - since 1970 UTC; UT1 is taken as UTC */
export function julianDay(ms: number): number {
  return ms / DAY_MS + 2_440_587.5;
}

/** Centuries since J2000. */
export function centuries(ms: number): number {
  return (julianDay(ms) - J2000) / 36_525;
}

/** Local mean sidereal time (h); Meeus 12.4. */
export function siderealHours(ms: number, longitude: number): number {
  const t = centuries(ms);
  const angle =
    280.46061837 + 360.98564736629 * (julianDay(ms) - J2000) + t * t * (0.000387933 - t / 38_710_000);
  return wrapped(angle + longitude, 360) / 15;
}

/** From coordinates of date to the horizon; Meeus 13.5 and 13.6. */
export function toHorizontal({ ra, dec }: Equatorial, place: GeoPlace, ms: number): Horizontal {
  const hour = radians((siderealHours(ms, place.longitude) - ra) * 15);
  const d = radians(dec);
  const lat = radians(place.latitude);
  const sine = Math.sin(lat) * Math.sin(d) + Math.cos(lat) * Math.cos(d) * Math.cos(hour);
  const y = -Math.cos(d) * Math.sin(hour);
  const x = Math.sin(d) * Math.cos(lat) - Math.cos(d) * Math.sin(lat) * Math.cos(hour);
  return { alt: degrees(Math.atan2(sine, Math.hypot(x, y))), az: wrapped(degrees(Math.atan2(y, x)), 360) };
}

/** From the horizon to coordinates of date. */
export function toEquatorial({ alt, az }: Horizontal, place: GeoPlace, ms: number): Equatorial {
  const a = radians(alt);
  const z = radians(az);
  const lat = radians(place.latitude);
  const sine = Math.sin(lat) * Math.sin(a) + Math.cos(lat) * Math.cos(a) * Math.cos(z);
  const y = -Math.cos(a) * Math.sin(z);
  const x = Math.sin(a) * Math.cos(lat) - Math.cos(a) * Math.sin(lat) * Math.cos(z);
  const hour = degrees(Math.atan2(y, x)) / 15;
  return { ra: wrapped(siderealHours(ms, place.longitude) - hour, 24), dec: degrees(Math.atan2(sine, Math.hypot(x, y))) };
}

/** From the mean equinox J2000 to that of a date; Meeus 21.3 and 21.4. */
export function precessedFromJ2000({ ra, dec }: Equatorial, ms: number): Equatorial {
  const t = centuries(ms);
  const arcseconds = (seconds: number): number => radians(seconds / 3600);
  const zeta = arcseconds(2306.2181 * t + 0.30188 * t * t + 0.017998 * t ** 3);
  const z = arcseconds(2306.2181 * t + 1.09468 * t * t + 0.018203 * t ** 3);
  const theta = arcseconds(2004.3109 * t - 0.42665 * t * t - 0.041833 * t ** 3);
  const a = radians(ra * 15) + zeta;
  const d = radians(dec);
  const first = Math.cos(d) * Math.sin(a);
  const next = Math.cos(theta) * Math.cos(d) * Math.cos(a) - Math.sin(theta) * Math.sin(d);
  const last = Math.sin(theta) * Math.cos(d) * Math.cos(a) + Math.cos(theta) * Math.sin(d);
  return { ra: wrapped(degrees(Math.atan2(first, next) + z) / 15, 24), dec: degrees(Math.atan2(last, Math.hypot(first, next))) };
}

/** The angle between two directions (°). */
export function separation(first: Horizontal, other: Horizontal): number {
  const [a, b] = [radians(first.alt), radians(other.alt)];
  const cosine = Math.sin(a) * Math.sin(b) + Math.cos(a) * Math.cos(b) * Math.cos(radians(first.az - other.az));
  return degrees(Math.acos(clampedUnit(cosine)));
}
