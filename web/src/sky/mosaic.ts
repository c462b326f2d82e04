/**
 * What a camera shows of the sky, and the panels by which it shows more: a mosaic. Pure.
 *
 * A mosaic is laid out on the plane that touches the sky in its middle. There its panels stand in
 * straight rows; on the sky each has an angle of its own, for meridians run together at the poles.
 */

import { degrees, radians, turned } from "./coordinates.js";
import { directionTo, fromPlane, toPlane, type PlanePoint, type SkyPoint } from "./tangent-plane.js";

/** How much a picture shows (°). */
export interface FieldSize {
  readonly width: number;
  readonly height: number;
}

export interface MosaicPlan {
  readonly across: number;
  readonly down: number;
  /** Part of a panel that its neighbour shows, too (0 to 0.9). */
  readonly overlap: number;
  /** Where the top of the mosaic points, from north through east (°). */
  readonly angle: number;
  /** Each panel may have an angle of its own: there is a rotator. Without one all have the mosaic's. */
  readonly rotates: boolean;
}

export interface MosaicPanel {
  /** From the top and from the left, from 1. */
  readonly row: number;
  readonly column: number;
  readonly centre: SkyPoint;
  /** Where its top points (°). */
  readonly angle: number;
}

export interface Mosaic {
  readonly panels: readonly MosaicPanel[];
  /** What it shows (°): without gaps, and measured along its middle. */
  readonly size: FieldSize;
  /** How far panels without a rotator are turned against its rows at the most (°). */
  readonly twist: number;
  /** How much nearer to each other they stand for that: 1 where nothing had to be done. */
  readonly scale: number;
}

/** Between two points by which a direction is measured (° of the plane). */
const STEP = 1e-3;
/** A panel that is turned more shows the same as one that is turned less, the other way round. */
const HALF_TURN = 180;
/** Turns are looked at so closely for the worst of them. */
const TURNS = 90;
const MOST_ROUNDS = 12;

/** The corners of a picture: top left, top right, bottom right, bottom left, as it is seen with its top up. */
export function fieldCorners(centre: SkyPoint, field: FieldSize, angle: number): readonly SkyPoint[] {
  const [x, y] = [halfOf(field.width), halfOf(field.height)];
  return ([[-x, y], [x, y], [x, -y], [-x, -y]] as const).map(([right, up]) => fromPlane(turnedBy(right, up, angle), centre));
}

/** Whether a picture shows a place. */
export function isInField(point: SkyPoint, centre: SkyPoint, field: FieldSize, angle: number): boolean {
  const at = toPlane(point, centre);
  if (at === null) return false;
  const { right, up } = alongPicture(at, angle);
  // A corner is shown however its last digit was rounded.
  return Math.abs(right) <= halfOf(field.width) * (1 + 1e-9) && Math.abs(up) <= halfOf(field.height) * (1 + 1e-9);
}

/** The panels about a place, row by row from the top left. */
export function mosaicOf(centre: SkyPoint, field: FieldSize, plan: MosaicPlan): Mosaic {
  let scale = 1;
  let laid = layOut(centre, field, plan, scale);
  // A fixed camera shows each panel at the same angle to its own meridian. Where meridians run
  // together panels turn against their rows: set so close that what stands upright in each of them,
  // however they are turned, still meets.
  for (let round = 0; round < MOST_ROUNDS && !plan.rotates; round += 1) {
    const needed = Math.min(scale, uprightPart(field, laid.twist));
    if (needed >= scale - 1e-12) break;
    scale = needed;
    laid = layOut(centre, field, plan, scale);
  }
  const extent = (size: number, many: number): number => 2 * degrees(Math.atan(radians((halfOf(size) * scale * (many - 1) * (1 - plan.overlap)) + halfOf(size) * scale)));
  return { ...laid, size: { width: extent(field.width, plan.across), height: extent(field.height, plan.down) }, scale };
}

function layOut(centre: SkyPoint, field: FieldSize, plan: MosaicPlan, scale: number): Pick<Mosaic, "panels" | "twist"> {
  const { across, down, overlap, angle, rotates } = plan;
  const [stepX, stepY] = [2 * halfOf(field.width) * scale * (1 - overlap), 2 * halfOf(field.height) * scale * (1 - overlap)];
  const panels: MosaicPanel[] = [];
  let twist = 0;
  for (let row = 0; row < down; row += 1) {
    for (let column = 0; column < across; column += 1) {
      const [right, up] = [(column - (across - 1) / 2) * stepX, ((down - 1) / 2 - row) * stepY];
      const at = fromPlane(turnedBy(right, up, angle), centre);
      // Which way the mosaic's top is from here, by what lies just above and just below.
      const below = fromPlane(turnedBy(right, up - STEP, angle), centre);
      const above = fromPlane(turnedBy(right, up + STEP, angle), centre);
      const upright = turned(directionTo(at, above) + shortTurn(directionTo(at, below) + HALF_TURN - directionTo(at, above)) / 2, 360);
      const isMiddle = right === 0 && up === 0;
      panels.push({ row: row + 1, column: column + 1, centre: at, angle: rotates && !isMiddle ? upright : turned(angle, 360) });
      if (!isMiddle) twist = Math.max(twist, foldedTurn(upright - angle));
    }
  }
  return { panels, twist: rotates ? 0 : twist };
}

/** The part of a picture, in both directions, that stays inside it upright when it is turned by so much, or less (°). */
function uprightPart({ width, height }: FieldSize, most: number): number {
  const [w, h] = [halfOf(width), halfOf(height)];
  let part = 1;
  for (let i = 0; i <= TURNS; i += 1) {
    const turn = radians((most * i) / TURNS);
    const [c, s] = [Math.cos(turn), Math.sin(turn)];
    part = Math.min(part, w / (w * c + h * s), h / (w * s + h * c));
  }
  return part;
}

/** Half of an angle's size on the plane (°). */
function halfOf(size: number): number {
  return degrees(Math.tan(radians(size) / 2));
}

/** From a picture's right and up to east and north; with its top at `angle`, east is to the left of north. */
function turnedBy(right: number, up: number, angle: number): PlanePoint {
  const [c, s] = [Math.cos(radians(angle)), Math.sin(radians(angle))];
  return { east: up * s - right * c, north: up * c + right * s };
}

function alongPicture({ east, north }: PlanePoint, angle: number): { readonly right: number; readonly up: number } {
  const [c, s] = [Math.cos(radians(angle)), Math.sin(radians(angle))];
  return { right: north * s - east * c, up: north * c + east * s };
}

/** The same turn as −180 to 180°. */
function shortTurn(turn: number): number {
  return turned(turn + HALF_TURN, 360) - HALF_TURN;
}

/** How far a rectangle is turned, for upside down it is the same (0 to 90°). */
function foldedTurn(turn: number): number {
  const folded = turned(turn, HALF_TURN);
  return Math.min(folded, HALF_TURN - folded);
}
