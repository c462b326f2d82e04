/** Draws grid, trail and vehicle on the map's canvas. No Leaflet here: it is told where things are. */

import { fixedText } from "../../format/number.js";
import { formatLength, isBreak, niceLength, type TrackPoint } from "./track.js";

export interface Pose {
  /** m */
  readonly x: number;
  /** m */
  readonly y: number;
  /** rad, counter-clockwise from x; NaN when it is not known */
  readonly yaw: number;
}

export interface Colours {
  readonly line: string;
  readonly strong: string;
  readonly text: string;
  readonly accent: string;
  readonly stale: string;
  readonly surface: string;
}

/** Where the map looks: a plain scale and shift, x to the right and y up. */
export interface MapView {
  /** px */
  readonly width: number;
  readonly height: number;
  /** px of one metre */
  readonly scale: number;
  /** Where the local origin lies (px from the left top). */
  readonly originX: number;
  readonly originY: number;
}

export interface MapScene {
  readonly trail: readonly TrackPoint[];
  readonly pose: Pose | null;
  /** Of its digital twin; null without one. */
  readonly ghost: Pose | null;
  /** The pose is older than its limit. */
  readonly stale: boolean;
}

/** Grid lines lie at least so far apart (px). */
const LEAST_STEP = 56;
const FINE_PER_STEP = 5;

type Pen = CanvasRenderingContext2D;

export function paintMap(pen: Pen, sight: MapView, scene: MapScene, colours: Colours, font: string): void {
  pen.clearRect(0, 0, sight.width, sight.height);
  const step = niceLength(LEAST_STEP / sight.scale);
  paintGrid(pen, sight, step / FINE_PER_STEP, colours.line, 0.45);
  paintGrid(pen, sight, step, colours.line, 1);
  paintAxes(pen, sight, colours);
  paintLabels(pen, sight, step, colours, font);
  paintTrail(pen, sight, scene, colours);
  // Below the robot: where both are the same, the robot is what counts.
  if (scene.ghost) paintGhost(pen, sight, scene.ghost, colours);
  if (scene.pose) paintVehicle(pen, sight, scene.pose, scene.stale, colours);
}

/** Length and pixels of a scale bar. */
export function scaleBar(scale: number): { readonly text: string; readonly px: number } {
  const length = niceLength(48 / scale);
  return { text: formatLength(length), px: length * scale };
}

function multiplesBetween(from: number, to: number, step: number): number[] {
  const first = Math.ceil(from / step);
  const count = Math.floor(to / step) - first + 1;
  return Array.from({ length: Math.min(Math.max(0, count), 2000) }, (_, i) => (first + i) * step);
}

function gridColumns(sight: MapView, step: number): number[] {
  return multiplesBetween(-sight.originX / sight.scale, (sight.width - sight.originX) / sight.scale, step);
}

function gridRows(sight: MapView, step: number): number[] {
  return multiplesBetween((sight.originY - sight.height) / sight.scale, sight.originY / sight.scale, step);
}

const pxX = (sight: MapView, x: number): number => sight.originX + x * sight.scale;
const pxY = (sight: MapView, y: number): number => sight.originY - y * sight.scale;

function paintGrid(pen: Pen, sight: MapView, step: number, colour: string, alpha: number): void {
  pen.beginPath();
  for (const x of gridColumns(sight, step)) {
    const at = Math.round(pxX(sight, x)) + 0.5;
    pen.moveTo(at, 0);
    pen.lineTo(at, sight.height);
  }
  for (const y of gridRows(sight, step)) {
    const at = Math.round(pxY(sight, y)) + 0.5;
    pen.moveTo(0, at);
    pen.lineTo(sight.width, at);
  }
  pen.globalAlpha = alpha;
  pen.strokeStyle = colour;
  pen.lineWidth = 1;
  pen.stroke();
  pen.globalAlpha = 1;
}

function paintAxes(pen: Pen, sight: MapView, colours: Colours): void {
  pen.beginPath();
  pen.moveTo(Math.round(sight.originX) + 0.5, 0);
  pen.lineTo(Math.round(sight.originX) + 0.5, sight.height);
  pen.moveTo(0, Math.round(sight.originY) + 0.5);
  pen.lineTo(sight.width, Math.round(sight.originY) + 0.5);
  pen.strokeStyle = colours.strong;
  pen.lineWidth = 1;
  pen.stroke();
}

function paintLabels(pen: Pen, sight: MapView, step: number, colours: Colours, font: string): void {
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const labelText = (value: number): string => (Math.abs(value) < step / 2 ? "0" : fixedText(value, digits).replace("-", "\u2212"));
  pen.font = font;
  pen.fillStyle = colours.text;
  pen.strokeStyle = colours.surface;
  pen.lineWidth = 3;
  const writeLabel = (text: string, x: number, y: number): void => {
    pen.strokeText(text, x, y);
    pen.fillText(text, x, y);
  };
  pen.textBaseline = "top";
  pen.textAlign = "center";
  // Corners are left to the buttons and the scale bar.
  for (const x of gridColumns(sight, step)) {
    const at = pxX(sight, x);
    if (at > 64 && at < sight.width - 20) writeLabel(labelText(x), at, 4);
  }
  pen.textBaseline = "middle";
  pen.textAlign = "right";
  for (const y of gridRows(sight, step)) {
    const at = pxY(sight, y);
    if (at > 24 && at < sight.height - 12) writeLabel(labelText(y), sight.width - 5, at);
  }
}

function paintTrail(pen: Pen, sight: MapView, scene: MapScene, colours: Colours): void {
  const last = scene.trail.at(-1);
  const points = scene.pose && last ? [...scene.trail, { ...scene.pose, timeUs: last.timeUs }] : scene.trail;
  pen.lineJoin = "round";
  pen.lineCap = "round";
  pen.strokeStyle = colours.accent;
  pen.lineWidth = 2.5;
  // Older stretches are fainter: the eye finds the end.
  const parts = 8;
  for (let part = 0; part < parts; part++) {
    const from = Math.floor((points.length * part) / parts);
    const to = Math.min(points.length - 1, Math.floor((points.length * (part + 1)) / parts));
    pen.beginPath();
    for (let i = from; i <= to; i++) {
      const [before, point] = [points[i - 1], points[i]];
      if (!point) continue;
      if (i === from || (before && isBreak(before, point))) pen.moveTo(pxX(sight, point.x), pxY(sight, point.y));
      else pen.lineTo(pxX(sight, point.x), pxY(sight, point.y));
    }
    pen.globalAlpha = 0.3 + (0.7 * (part + 1)) / parts;
    pen.stroke();
  }
  pen.globalAlpha = 1;
}

/** Inks the path of the mark of a robot: in its colour, or as one whose place is old. */
export function inkMark(pen: Pen, colours: Colours, stale: boolean, colour: string): void {
  pen.lineJoin = "round";
  pen.lineWidth = 5;
  pen.strokeStyle = colours.surface;
  pen.stroke();
  pen.lineWidth = 2;
  pen.strokeStyle = stale ? colours.stale : colour;
  // Hollow and dashed says "old" without colour.
  if (stale) pen.setLineDash([3, 3]);
  else {
    pen.fillStyle = colour;
    pen.fill();
  }
  pen.stroke();
}

/** Translucent and with a dashed edge: a twin is not taken for the robot, without colour either. */
function paintGhost(pen: Pen, sight: MapView, ghost: Pose, colours: Colours): void {
  pen.save();
  pen.translate(pxX(sight, ghost.x), pxY(sight, ghost.y));
  pen.rotate(Number.isFinite(ghost.yaw) ? -ghost.yaw : 0);
  pen.beginPath();
  pen.moveTo(20, 0);
  pen.lineTo(-13, 13);
  pen.lineTo(-7, 0);
  pen.lineTo(-13, -13);
  pen.closePath();
  pen.globalAlpha = 0.35;
  pen.fillStyle = colours.accent;
  pen.fill();
  pen.globalAlpha = 1;
  pen.setLineDash([3, 3]);
  pen.strokeStyle = colours.accent;
  pen.stroke();
  pen.restore();
}

function paintVehicle(pen: Pen, sight: MapView, pose: Pose, stale: boolean, colours: Colours): void {
  pen.save();
  pen.translate(pxX(sight, pose.x), pxY(sight, pose.y));
  pen.beginPath();
  if (Number.isFinite(pose.yaw)) {
    pen.rotate(-pose.yaw);
    pen.moveTo(16, 0);
    pen.lineTo(-10, 10);
    pen.lineTo(-5, 0);
    pen.lineTo(-10, -10);
    pen.closePath();
  } else {
    pen.arc(0, 0, 8, 0, Math.PI * 2);
  }
  inkMark(pen, colours, stale, colours.accent);
  pen.restore();
}
