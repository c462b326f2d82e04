/** The messages that a scene is made of, read from their bytes. Pure. */

import type { MessageReader } from "./cdr.js";
import { frameName } from "./frame-tree.js";
import { normalized, type Transform, type Vector } from "./transform.js";

export interface MessageHeader {
  readonly timeUs: number;
  readonly frame: string;
}

export interface LaserScan extends MessageHeader {
  readonly angleMin: number;
  readonly angleStep: number;
  readonly rangeMin: number;
  readonly rangeMax: number;
  readonly ranges: Float32Array;
}

export interface Poses extends MessageHeader {
  readonly poses: readonly Transform[];
}

export interface Odometry extends MessageHeader {
  readonly child: string;
  readonly pose: Transform;
}

export interface JointState extends MessageHeader {
  readonly names: readonly string[];
  readonly positions: readonly number[];
}

export interface OccupancyGrid extends MessageHeader {
  /** m */
  readonly resolution: number;
  readonly width: number;
  readonly height: number;
  readonly origin: Transform;
  /** By rows from the origin: 0 to 100, or 255 (-1) where nothing is known. */
  readonly cells: Uint8Array;
}

export interface GridUpdate extends MessageHeader {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
  readonly cells: Uint8Array;
}

export interface StampedTransform extends MessageHeader {
  readonly child: string;
  readonly transform: Transform;
}

export function readHeader(reader: MessageReader): MessageHeader {
  // A sequence number that ROS 2 has not.
  if (reader.ros1) reader.uint32();
  const timeUs = reader.int32() * 1e6 + reader.uint32() / 1000;
  return { timeUs, frame: frameName(reader.text()) };
}

export function readVector(reader: MessageReader): Vector {
  return [reader.float64(), reader.float64(), reader.float64()];
}

/** Of `Pose` and `Transform`, which are alike. */
export function readPose(reader: MessageReader): Transform {
  const at = readVector(reader);
  return { at, turn: normalized([reader.float64(), reader.float64(), reader.float64(), reader.float64()]) };
}

/** `tf2_msgs/msg/TFMessage` */
export function readTransforms(reader: MessageReader): StampedTransform[] {
  return reader.list(64, () => {
    const { timeUs, frame } = readHeader(reader);
    const child = frameName(reader.text());
    return { timeUs, frame, child, transform: readPose(reader) };
  });
}

/** `sensor_msgs/msg/LaserScan` */
export function readScan(reader: MessageReader): LaserScan {
  const header = readHeader(reader);
  const angleMin = reader.float32();
  reader.float32();
  const angleStep = reader.float32();
  reader.skip(2, 4);
  return { ...header, angleMin, angleStep, rangeMin: reader.float32(), rangeMax: reader.float32(), ranges: reader.float32s() };
}

/** Where the beams of a scan ended, in its frame: x, y, z of each that hit something. */
export function scanPoints({ angleMin, angleStep, rangeMin, rangeMax, ranges }: LaserScan): Float32Array {
  const found = new Float32Array(ranges.length * 3);
  let count = 0;
  for (let i = 0; i < ranges.length; i++) {
    const range = ranges[i] ?? Number.NaN;
    // By REP-117 what is not finite met nothing, or was too near.
    if (!(range >= rangeMin && range <= rangeMax)) continue;
    const angle = angleMin + i * angleStep;
    found[count++] = range * Math.cos(angle);
    found[count++] = range * Math.sin(angle);
    count++;
  }
  return found.subarray(0, count);
}

/** `nav_msgs/msg/Path` */
export function readPath(reader: MessageReader): Poses {
  const header = readHeader(reader);
  const poses = reader.list(68, () => {
    readHeader(reader);
    return readPose(reader);
  });
  return { ...header, poses };
}

/** `geometry_msgs/msg/PoseArray` */
export function readPoseArray(reader: MessageReader): Poses {
  const header = readHeader(reader);
  return { ...header, poses: reader.list(56, () => readPose(reader)) };
}

/** `geometry_msgs/msg/PoseStamped`, also `…WithCovarianceStamped`, whose pose comes first, too. */
export function readStampedPose(reader: MessageReader): Poses {
  return { ...readHeader(reader), poses: [readPose(reader)] };
}

/** `nav_msgs/msg/Odometry` */
export function readOdometry(reader: MessageReader): Odometry {
  const header = readHeader(reader);
  return { ...header, child: frameName(reader.text()), pose: readPose(reader) };
}

/** `sensor_msgs/msg/JointState` */
export function readJoints(reader: MessageReader): JointState {
  return { ...readHeader(reader), names: reader.list(4, () => reader.text()), positions: reader.float64s() };
}

/** `nav_msgs/msg/OccupancyGrid` */
export function readGrid(reader: MessageReader): OccupancyGrid {
  const header = readHeader(reader);
  // When the map was loaded.
  reader.skip(2, 4);
  const resolution = reader.float32();
  const width = reader.uint32();
  const height = reader.uint32();
  return { ...header, resolution, width, height, origin: readPose(reader), cells: reader.octets() };
}

/** `map_msgs/msg/OccupancyGridUpdate` */
export function readGridUpdate(reader: MessageReader): GridUpdate {
  const header = readHeader(reader);
  const [x, y] = [reader.int32(), reader.int32()];
  return { ...header, x, y, width: reader.uint32(), height: reader.uint32(), cells: reader.octets() };
}

/** The grid with a part of it anew; as it was where the part does not fit. */
export function updatedGrid(grid: OccupancyGrid, part: GridUpdate): OccupancyGrid {
  const { x, y, width, height, cells } = part;
  if (x < 0 || y < 0 || x + width > grid.width || y + height > grid.height || cells.length < width * height) return grid;
  const whole = new Uint8Array(grid.cells);
  for (let row = 0; row < height; row++) whole.set(cells.subarray(row * width, (row + 1) * width), (y + row) * grid.width + x);
  return { ...grid, timeUs: part.timeUs, cells: whole };
}

/** `std_msgs/msg/String` */
export function readString(reader: MessageReader): string {
  return reader.text();
}
