/** `sensor_msgs/msg/CameraInfo`: where in space the pixels of a picture look, in its optical frame (REP-103: x right, y down, z ahead). Pure. */

import type { MessageReader } from "./cdr.js";
import { readHeader, type MessageHeader } from "./messages.js";
import type { Vector } from "./transform.js";

export interface CameraInfo extends MessageHeader {
  /** px of a whole picture, before binning and cutting. */
  readonly width: number;
  readonly height: number;
  /** How its lens bends: `plumb_bob`, `rational_polynomial`, `equidistant`, … */
  readonly distortion: string;
  readonly d: readonly number[];
  /** fx 0 cx, 0 fy cy, 0 0 1: of the picture as it comes (px). */
  readonly k: readonly number[];
  /** Of a rectified picture: three rows of four. */
  readonly p: readonly number[];
  /** What of the whole picture is sent (px); all of it where its width is 0. */
  readonly region: { readonly x: number; readonly y: number; readonly width: number; readonly height: number };
}

/** A picture's plane as triangles: where each corner is in the optical frame (m), and which part of the picture it shows (0 to 1, from its upper left). */
export interface PicturePlane {
  readonly positions: Float32Array;
  readonly parts: Float32Array;
  readonly triangles: Uint16Array;
  /** Upper left, upper right, lower right, lower left. */
  readonly corners: readonly [Vector, Vector, Vector, Vector];
}

/** Squares along each side of a picture whose lens bends. */
const SQUARES = 12;
/** Steps until a point of the picture is found without the lens: each makes it some ten times better. */
const STEPS = 20;
/** Beyond it (rad) a lens that sees nearly everything is not drawn: its plane would have no end. */
const MOST_ANGLE = 1.4;

export function readCameraInfo(reader: MessageReader): CameraInfo {
  const header = readHeader(reader);
  const height = reader.uint32();
  const width = reader.uint32();
  const distortion = reader.text();
  const d = reader.float64s();
  const numbers = (count: number): number[] => Array.from({ length: count }, () => reader.float64());
  const k = numbers(9);
  numbers(9);
  const p = numbers(12);
  // Binning makes the same picture of fewer pixels.
  reader.skip(2, 4);
  const [x, y] = [reader.uint32(), reader.uint32()];
  const region = { x, y, height: reader.uint32(), width: reader.uint32() };
  return { ...header, width, height, distortion, d, k, p, region };
}

/** Whether it says where its pixels look; who has not calibrated a camera sends zeros. */
export function isCalibrated({ k, width, height }: CameraInfo): boolean {
  return width > 0 && height > 0 && (k[0] ?? 0) > 0 && (k[4] ?? 0) > 0 && [...k].every(Number.isFinite);
}

/** What the calibration says of pictures that were rectified by it: no lens bends them any more. */
export function rectifiedInfo(info: CameraInfo): CameraInfo {
  const [fx = 0, skew = 0, cx = 0, , , fy = 0, cy = 0] = info.p;
  return fx > 0 && fy > 0 ? { ...info, d: [], k: [fx, skew, cx, 0, fy, cy, 0, 0, 1] } : info;
}

/** What makes its plane another one: two messages that agree in it look the same. */
export function planeKey({ width, height, distortion, d, k, region }: CameraInfo): string {
  return JSON.stringify([width, height, distortion, d, k, region]);
}

/** Where a pixel looks: x and y of the point that it shows one metre ahead. */
export function pixelRay({ k, d, distortion }: CameraInfo, u: number, v: number): readonly [x: number, y: number] {
  const [fx = 1, skew = 0, cx = 0, , fy = 1, cy = 0] = k;
  const y = (v - cy) / fy;
  const x = (u - cx - skew * y) / fx;
  if (!isBent(d)) return [x, y];
  return distortion === "equidistant" || distortion === "fisheye" ? withoutFisheye(x, y, d) : withoutBrown(x, y, d);
}

/** The plane of a picture so far ahead of its camera (m), bent as its lens needs it. */
export function picturePlane(info: CameraInfo, ahead: number): PicturePlane {
  const { region, width, height } = info;
  const sent = region.width > 0 && region.height > 0 ? region : { x: 0, y: 0, width, height };
  const squares = isBent(info.d) ? SQUARES : 1;
  const side = squares + 1;
  const positions = new Float32Array(3 * side * side);
  const parts = new Float32Array(2 * side * side);
  const triangles = new Uint16Array(6 * squares * squares);
  let point = 0;
  let corner = 0;
  for (let row = 0; row < side; row++) {
    for (let column = 0; column < side; column++, point++) {
      const [across, down] = [column / squares, row / squares];
      // A pixel's number is that of its middle.
      const [x, y] = pixelRay(info, sent.x + across * sent.width - 0.5, sent.y + down * sent.height - 0.5);
      positions.set([x * ahead, y * ahead, ahead], 3 * point);
      parts.set([across, down], 2 * point);
      if (row === squares || column === squares) continue;
      triangles.set([point, point + side, point + 1, point + 1, point + side, point + side + 1], corner);
      corner += 6;
    }
  }
  const at = (index: number): Vector => [positions[3 * index] ?? 0, positions[3 * index + 1] ?? 0, positions[3 * index + 2] ?? 0];
  return { positions, parts, triangles, corners: [at(0), at(squares), at(side * side - 1), at(side * squares)] };
}

function isBent(d: readonly number[]): boolean {
  return d.some((part) => part !== 0 && Number.isFinite(part));
}

/** `plumb_bob` and `rational_polynomial`: k1 k2 p1 p2 k3, and k4 k5 k6. */
function withoutBrown(x: number, y: number, d: readonly number[]): readonly [number, number] {
  const [k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0, k4 = 0, k5 = 0, k6 = 0] = d;
  let [found, foundY] = [x, y];
  for (let step = 0; step < STEPS; step++) {
    const r2 = found * found + foundY * foundY;
    const stretched = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
    // What a lens cannot have: the pixel is beyond where its numbers mean anything.
    if (!(stretched > 0.05)) return [x, y];
    const aside = 2 * p1 * found * foundY + p2 * (r2 + 2 * found * found);
    const asideY = p1 * (r2 + 2 * foundY * foundY) + 2 * p2 * found * foundY;
    [found, foundY] = [(x - aside) / stretched, (y - asideY) / stretched];
  }
  return Number.isFinite(found + foundY) ? [found, foundY] : [x, y];
}

/** `equidistant`: how far from the middle a pixel is tells the angle to the axis. */
function withoutFisheye(x: number, y: number, d: readonly number[]): readonly [number, number] {
  const [k1 = 0, k2 = 0, k3 = 0, k4 = 0] = d;
  const radius = Math.hypot(x, y);
  if (radius < 1e-9) return [x, y];
  let angle = Math.min(radius, MOST_ANGLE);
  for (let step = 0; step < STEPS; step++) {
    const t2 = angle * angle;
    const bent = angle * (1 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))));
    const slope = 1 + t2 * (3 * k1 + t2 * (5 * k2 + t2 * (7 * k3 + t2 * 9 * k4)));
    if (!(Math.abs(slope) > 1e-6)) break;
    angle = Math.min(MOST_ANGLE, Math.max(0, angle - (bent - radius) / slope));
  }
  const scale = Math.tan(angle) / radius;
  return [x * scale, y * scale];
}
