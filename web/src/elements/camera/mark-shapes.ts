/** Where zones, lines and paths of a picture lie in the view, and what is said at them: pure sums. */

import { msg, str } from "@lit/localize";
import { roundText } from "../../format/number.js";
import { countText } from "../../format/object-names.js";
import { formatDuration } from "../../format/duration.js";
import { placeOf, type PixelSize } from "./picture-fit.js";
import type { Zoom } from "./zoom.js";

/** Parts of the picture's width and height, from its left upper corner. */
export type PicturePoint = readonly [number, number];

export interface ViewPoint {
  readonly x: number;
  readonly y: number;
}

/** A zone or a line, and what its signals tell now. */
export interface PictureMark {
  readonly kind: "zone" | "line";
  readonly id: string;
  readonly name: string;
  readonly points: readonly PicturePoint[];
  /** `2 persons`, `left 3`; empty where nothing counts at it. */
  readonly counts: readonly string[];
}

/** The points in pixels of the view. */
export function viewPoints(points: readonly PicturePoint[], view: PixelSize, picture: PixelSize, zoom: Zoom): ViewPoint[] {
  return points.map(([x, y]) => placeOf({ left: x, top: y, right: x, bottom: y }, view, picture, zoom));
}

/** For the attribute `points` of SVG. */
export function pointsText(points: readonly ViewPoint[]): string {
  return points.map(({ x, y }) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ");
}

/** Where a mark's name stands: in the middle of its corners, or of the way along a line. */
export function nameSpot(kind: PictureMark["kind"], points: readonly ViewPoint[]): ViewPoint {
  if (points.length === 0) return { x: 0, y: 0 };
  if (kind === "zone") {
    const sum = points.reduce((all, { x, y }) => ({ x: all.x + x, y: all.y + y }));
    return { x: sum.x / points.length, y: sum.y / points.length };
  }
  const steps = points.slice(1).map((to, i) => {
    const from = points[i] ?? to;
    return { from, to, length: Math.hypot(to.x - from.x, to.y - from.y) };
  });
  let left = steps.reduce((all, { length }) => all + length, 0) / 2;
  for (const { from, to, length } of steps) {
    if (length > 0 && left <= length) {
      const part = left / length;
      return { x: from.x + (to.x - from.x) * part, y: from.y + (to.y - from.y) * part };
    }
    left -= length;
  }
  return points[0] ?? { x: 0, y: 0 };
}

/** Beside a place of a line, so far off: where its left and its right side are, seen from its first point to its last. */
export function sideSpots(points: readonly ViewPoint[], away: number, middle: ViewPoint): { readonly left: ViewPoint; readonly right: ViewPoint } {
  const [first, last] = [points[0] ?? middle, points.at(-1) ?? middle];
  const length = Math.max(1, Math.hypot(last.x - first.x, last.y - first.y));
  // Rows run downwards, so left of the way is up where the way leads to the right.
  const [x, y] = [((last.y - first.y) / length) * away, (-(last.x - first.x) / length) * away];
  return { left: { x: middle.x + x, y: middle.y + y }, right: { x: middle.x - x, y: middle.y - y } };
}

/** What is told of a class in per cent. */
const PERCENT: Readonly<Record<string, (label: string, part: string) => string>> = {
  share: (label, part) => `${label} ${part}`,
  ahead: (label, part) => msg(str`${label} ahead ${part}`),
  left_edge: (label, part) => msg(str`${label} from ${part}`),
  right_edge: (label, part) => msg(str`${label} to ${part}`),
};

/** @param value - what a signal tells at its mark; null for one that tells nothing now (stale, or not yet) */
export function markCount(measure: string, label: string, value: number | null): string {
  if (measure === "dwell") return value === null ? msg("longest –") : msg(str`longest ${formatDuration(value)}`);
  if (measure === "nearest") return value === null ? msg("nearest –") : msg(str`nearest ${roundText(value, 2)}`);
  const percent = PERCENT[measure];
  if (percent !== undefined) return percent(label, value === null ? "\u2013" : `${String(Math.round(value))}\u00a0%`);
  const many = value === null ? null : Math.round(value);
  if (measure === "left") return msg(str`left ${many === null ? "\u2013" : String(many)}`);
  if (measure === "right") return msg(str`right ${many === null ? "\u2013" : String(many)}`);
  return many === null ? `\u2013 ${label}` : countText(many, label);
}

/** The head of an arrow at a line's end, so that left and right of it can be told; empty for a point. */
export function arrowHead(points: readonly ViewPoint[], size: number): ViewPoint[] {
  const end = points.at(-1);
  const before = [...points].reverse().find(({ x, y }) => end !== undefined && (x !== end.x || y !== end.y));
  if (end === undefined || before === undefined) return [];
  const length = Math.hypot(end.x - before.x, end.y - before.y);
  const along = { x: (end.x - before.x) / length, y: (end.y - before.y) / length };
  const back = { x: end.x - along.x * size, y: end.y - along.y * size };
  const half = size / 2;
  return [
    { x: back.x - along.y * half, y: back.y + along.x * half },
    end,
    { x: back.x + along.y * half, y: back.y - along.x * half },
  ];
}
