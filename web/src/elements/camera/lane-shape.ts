/** The lane as it lies on a camera's picture, and what is said at it: pure sums. */

import { msg, str } from "@lit/localize";
import type { PictureMark, PicturePoint } from "./mark-shapes.js";

/** From metres before the vehicle (x ahead, y left) to parts of the picture, row by row. */
export type Homography = readonly number[];

/** Where the vehicle is in its lane now. */
export interface LanePlace {
  /** Left of the middle (m). */
  readonly offset: number;
  /** Against the lane, counter-clockwise (rad). */
  readonly heading: number;
  /** From marking to marking (m). */
  readonly width: number;
}

/** A place of the floor on the picture; null behind the camera. */
function pictureOf(matrix: Homography, x: number, y: number): PicturePoint | null {
  const row = (at: number): number => (matrix[at] ?? 0) * x + (matrix[at + 1] ?? 0) * y + (matrix[at + 2] ?? 0);
  const w = row(6);
  return w > 0 ? [row(0) / w, row(3) / w] : null;
}

/** The lane's corners on the picture, from the near left one around; empty where they cannot be seen. */
export function laneOutline(matrix: Homography, [near, far]: readonly [number, number], { offset, heading, width }: LanePlace): PicturePoint[] {
  // The lane is straight: seen from the vehicle it runs off at minus its heading.
  const slope = Math.tan(-heading);
  const stretch = Math.hypot(1, slope);
  const middle = -offset * stretch;
  const side = (x: number, sign: number): PicturePoint | null => pictureOf(matrix, x, middle + slope * x + (sign * width * stretch) / 2);
  const corners = [side(near, 1), side(far, 1), side(far, -1), side(near, -1)];
  return corners.every((corner) => corner !== null) ? corners : [];
}

/** `12 cm left`, as people say it. */
export function offsetText(offset: number): string {
  const cm = Math.round(Math.abs(offset) * 100);
  return cm === 0 ? msg("in the middle") : offset > 0 ? msg(str`${String(cm)}\u00a0cm left`) : msg(str`${String(cm)}\u00a0cm right`);
}

/** The mark that lies over the picture; null while nothing is known. */
export function laneMark(matrix: Homography, ahead: readonly [number, number], place: LanePlace): PictureMark | null {
  const points = laneOutline(matrix, ahead, place);
  return points.length === 0 ? null : { kind: "zone", id: "lane", name: msg("Lane"), points, counts: [offsetText(place.offset)] };
}
