/**
 * The gnomonic projection: a piece of the sky on the plane that touches it, as a camera shows it. Pure.
 *
 * Formulas from Calabretta and Greisen 2002, Astronomy & Astrophysics 395, 1077, section 5.1.3.
 * Degrees throughout, also on the plane. Right also at the poles, where right ascensions meet.
 */

import { degrees, radians, turned } from "./coordinates.js";

/** A direction among the stars (°, J2000). */
export interface SkyPoint {
  readonly raDeg: number;
  readonly decDeg: number;
}

/** A place on the plane (°): to the east and to the north of the point where it touches the sky. */
export interface PlanePoint {
  readonly east: number;
  readonly north: number;
}

/** So near the edge of the half of the sky that the plane shows, nothing is drawn (cosine). */
const EDGE = 1e-6;

/** Null for what stands behind whoever looks at `centre`. */
export function toPlane({ raDeg, decDeg }: SkyPoint, centre: SkyPoint): PlanePoint | null {
  const [a, d, d0] = [radians(raDeg - centre.raDeg), radians(decDeg), radians(centre.decDeg)];
  const along = Math.sin(d0) * Math.sin(d) + Math.cos(d0) * Math.cos(d) * Math.cos(a);
  if (!(along > EDGE)) return null;
  return {
    east: degrees((Math.cos(d) * Math.sin(a)) / along),
    north: degrees((Math.cos(d0) * Math.sin(d) - Math.sin(d0) * Math.cos(d) * Math.cos(a)) / along),
  };
}

export function fromPlane({ east, north }: PlanePoint, centre: SkyPoint): SkyPoint {
  const [x, y, d0] = [radians(east), radians(north), radians(centre.decDeg)];
  const along = Math.cos(d0) - y * Math.sin(d0);
  return {
    raDeg: turned(centre.raDeg + degrees(Math.atan2(x, along)), 360),
    decDeg: degrees(Math.atan2(Math.sin(d0) + y * Math.cos(d0), Math.hypot(x, along))),
  };
}

/** The angle between two directions (°); exact for small ones. */
export function separation(one: SkyPoint, other: SkyPoint): number {
  const across = Math.cos(radians(one.decDeg)) * Math.cos(radians(other.decDeg));
  const square = Math.sin(radians(other.decDeg - one.decDeg) / 2) ** 2 + across * Math.sin(radians(other.raDeg - one.raDeg) / 2) ** 2;
  return degrees(2 * Math.asin(Math.sqrt(Math.min(1, square))));
}

/** Where a direction lies from another: from north through east (°, 0 to 360). */
export function directionTo(from: SkyPoint, to: SkyPoint): number {
  const [a, d, d0] = [radians(to.raDeg - from.raDeg), radians(to.decDeg), radians(from.decDeg)];
  const east = Math.cos(d) * Math.sin(a);
  return turned(degrees(Math.atan2(east, Math.cos(d0) * Math.sin(d) - Math.sin(d0) * Math.cos(d) * Math.cos(a))), 360);
}
