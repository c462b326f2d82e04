/** A dome seen from the south and a little from above, as points of a drawing. Pure. */

import { radians } from "../../sky/coordinates.js";

export interface ProjectedPoint {
  readonly x: number;
  readonly y: number;
  /** The outside of the dome is turned to whoever looks. */
  readonly front: boolean;
}

/** How far the eye is above the ground (°). */
const PITCH = 24;
const [RISE, LEAN] = [Math.cos(radians(PITCH)), Math.sin(radians(PITCH))];

/** Half the breadth of the slit, of the dome's radius. */
export const SLIT = 0.2;
/** The slit goes from the base over the zenith to here (°). */
const OVER = 108;
const STEP = 6;

/** From east, north and up (of the radius) to the drawing: x to the right, y down. */
export function project(east: number, north: number, up: number): ProjectedPoint {
  return { x: east, y: -(up * RISE + north * LEAN), front: up * LEAN - north * RISE > 0 };
}

/** A point of the ground, at a distance from the dome's middle. */
export function groundPoint(azimuth: number, distance: number): ProjectedPoint {
  const a = radians(azimuth);
  return project(distance * Math.sin(a), distance * Math.cos(a), 0);
}

/** How flat a circle on the ground looks. */
export const FLATNESS = LEAN;

/**
 * The edge of a strip over the dome, from its base over the top.
 *
 * @param side - distance from the strip's middle, of the radius
 */
export function edgePoints(azimuth: number, side: number): readonly ProjectedPoint[] {
  const a = radians(azimuth);
  const round = Math.sqrt(1 - side * side);
  const points: ProjectedPoint[] = [];
  for (let angle = 0; angle <= OVER; angle += STEP) {
    const along = round * Math.cos(radians(angle));
    const up = round * Math.sin(radians(angle));
    points.push(project(along * Math.sin(a) + side * Math.cos(a), along * Math.cos(a) - side * Math.sin(a), up));
  }
  return points;
}

/** The strip between two edges as the points of a polygon; only what is in front, or all of it. */
export function stripPolygon(azimuth: number, from: number, to: number, hidden = false): string {
  const visiblePoints = (points: readonly ProjectedPoint[]): readonly ProjectedPoint[] => (hidden ? points : points.filter(({ front }) => front));
  const [one, other] = [visiblePoints(edgePoints(azimuth, from)), visiblePoints(edgePoints(azimuth, to))];
  if (one.length < 2 || other.length < 2) return "";
  return pointsOf([...one, ...[...other].reverse()]);
}

export function pointsOf(points: readonly { readonly x: number; readonly y: number }[], scale = 100): string {
  return points.map(({ x, y }) => `${(x * scale).toFixed(1)},${(y * scale).toFixed(1)}`).join(" ");
}
