/**
 * Places on the ellipsoid of WGS 84, and on the plane that touches it at an origin. Pure.
 *
 * Exact, and not by a mean radius: that is wrong by some metres after a kilometre, and a robot is
 * looked at to a centimetre.
 */

/** A place in degrees, WGS 84. */
export interface MapPlace {
  readonly lat: number;
  readonly lon: number;
}

/** m on a plane. */
export interface GroundPoint {
  readonly x: number;
  readonly y: number;
}

/** Where a local frame's zero is, and where its x points: degrees clockwise from true north. */
export interface MapFrame extends MapPlace {
  readonly heading: number;
}

/** Half the greater axis (m) and the flattening. */
const AXIS = 6_378_137;
const FLATTENING = 1 / 298.257223563;
const ECC2 = FLATTENING * (2 - FLATTENING);
const RADIANS = Math.PI / 180;

type Triple = readonly [x: number, y: number, z: number];

function earthCentred({ lat, lon }: MapPlace): Triple {
  const [sin, cos] = [Math.sin(lat * RADIANS), Math.cos(lat * RADIANS)];
  const normal = AXIS / Math.sqrt(1 - ECC2 * sin * sin);
  return [normal * cos * Math.cos(lon * RADIANS), normal * cos * Math.sin(lon * RADIANS), normal * (1 - ECC2) * sin];
}

/** East and north of an origin (m), on the plane that touches there. */
export function flatPosition(place: MapPlace, origin: MapPlace): GroundPoint {
  const [at, zero] = [earthCentred(place), earthCentred(origin)];
  const [dx, dy, dz] = [at[0] - zero[0], at[1] - zero[1], at[2] - zero[2]];
  const [sinLat, cosLat] = [Math.sin(origin.lat * RADIANS), Math.cos(origin.lat * RADIANS)];
  const [sinLon, cosLon] = [Math.sin(origin.lon * RADIANS), Math.cos(origin.lon * RADIANS)];
  return {
    x: -sinLon * dx + cosLon * dy,
    y: -sinLat * cosLon * dx - sinLat * sinLon * dy + cosLat * dz,
  };
}

/** The place that lies so far east and north of an origin (m) on the plane that touches there. */
export function placeOfFlat({ x, y }: GroundPoint, origin: MapPlace): MapPlace {
  const zero = earthCentred(origin);
  const [sinLat, cosLat] = [Math.sin(origin.lat * RADIANS), Math.cos(origin.lat * RADIANS)];
  const [sinLon, cosLon] = [Math.sin(origin.lon * RADIANS), Math.cos(origin.lon * RADIANS)];
  const atX = zero[0] - sinLon * x - sinLat * cosLon * y;
  const atY = zero[1] + cosLon * x - sinLat * sinLon * y;
  const atZ = zero[2] + cosLat * y;
  // Bowring's way: one step is exact to far below a millimetre near the ground.
  const across = Math.hypot(atX, atY);
  const minor = AXIS * (1 - FLATTENING);
  const reduced = Math.atan2(atZ * AXIS, across * minor);
  const second = ECC2 / (1 - ECC2);
  const lat = Math.atan2(atZ + second * minor * Math.sin(reduced) ** 3, across - ECC2 * AXIS * Math.cos(reduced) ** 3);
  return { lat: lat / RADIANS, lon: Math.atan2(atY, atX) / RADIANS };
}

/** The place of a point of a local frame. */
export function placeOfLocal({ x, y }: GroundPoint, frame: MapFrame): MapPlace {
  const [sin, cos] = [Math.sin(frame.heading * RADIANS), Math.cos(frame.heading * RADIANS)];
  return placeOfFlat({ x: x * sin - y * cos, y: x * cos + y * sin }, frame);
}

/** What a yaw of a local frame (rad, counter-clockwise from x) is from true north (°, clockwise, 0 to 360). */
export function headingOfYaw(yaw: number, frameHeading: number): number {
  return ((((frameHeading - yaw / RADIANS) % 360) + 360) % 360);
}

/** Distance (m) and direction (°, clockwise from true north) from one place to another that is near. */
export function wayBetween(from: MapPlace, to: MapPlace): { readonly metres: number; readonly heading: number } {
  const { x, y } = flatPosition(to, from);
  return { metres: Math.hypot(x, y), heading: (Math.atan2(x, y) / RADIANS + 360) % 360 };
}
