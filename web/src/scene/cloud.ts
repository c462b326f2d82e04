/** `sensor_msgs/msg/PointCloud2`: points and what colours them. Pure. */

import { msg, str } from "@lit/localize";
import { MessageError, type MessageReader } from "./cdr.js";
import { readHeader, type MessageHeader } from "./messages.js";

interface PointField {
  readonly name: string;
  readonly offset: number;
  readonly datatype: number;
}

/** What colours the points. */
export type CloudColour = "height" | "intensity" | "rgb";

export interface PointCloud extends MessageHeader {
  /** x, y, z of each (m). */
  readonly positions: Float32Array;
  /** 0 to 1 from the least to the greatest; null where the points have none. */
  readonly intensity: Float32Array | null;
  /** Red, green and blue, 0 to 255; null where the points have none. */
  readonly rgb: Uint8Array | null;
}

/** The datatypes of `PointField`: how each is read, and its size. */
const READERS: Readonly<Record<number, readonly [size: number, read: (view: DataView, at: number, little: boolean) => number]>> = {
  1: [1, (view, at) => view.getInt8(at)],
  2: [1, (view, at) => view.getUint8(at)],
  3: [2, (view, at, little) => view.getInt16(at, little)],
  4: [2, (view, at, little) => view.getUint16(at, little)],
  5: [4, (view, at, little) => view.getInt32(at, little)],
  6: [4, (view, at, little) => view.getUint32(at, little)],
  7: [4, (view, at, little) => view.getFloat32(at, little)],
  8: [8, (view, at, little) => view.getFloat64(at, little)],
};
const FIELD_BYTES = 13;

export function readCloud(reader: MessageReader): PointCloud {
  const header = readHeader(reader);
  const height = reader.uint32();
  const width = reader.uint32();
  const fields = reader.list(FIELD_BYTES, (): PointField => {
    const field = { name: reader.text(), offset: reader.uint32(), datatype: reader.uint8() };
    reader.uint32();
    return field;
  });
  const little = !reader.bool();
  const step = reader.uint32();
  const row = reader.uint32();
  const data = reader.octets();
  if (step < 1 || row < width * step || height * row > data.length) throw new MessageError(msg("a cloud whose sizes do not fit"));
  const layout = { view: new DataView(data.buffer, data.byteOffset, data.byteLength), little, width, height, step, row };
  const [x, y, z] = ["x", "y", "z"].map((name) => valuesOf(layout, fields, name));
  if (!x || !y || !z) throw new MessageError(msg("a cloud whose points have no x, y and z"));
  return { ...header, ...packed(x, y, z, valuesOf(layout, fields, "intensity"), coloursOf(layout, fields)) };
}

interface Layout {
  readonly view: DataView;
  readonly little: boolean;
  readonly width: number;
  readonly height: number;
  readonly step: number;
  readonly row: number;
}

function valuesOf({ view, little, width, height, step, row }: Layout, fields: readonly PointField[], name: string): Float32Array | null {
  const field = fields.find((described) => described.name === name);
  const reading = field === undefined ? undefined : READERS[field.datatype];
  if (field === undefined || reading === undefined) return null;
  const [size, read] = reading;
  if (field.offset + size > step) throw new MessageError(msg(str`a cloud whose ${name} lies beside its points`));
  const found = new Float32Array(width * height);
  let count = 0;
  for (let line = 0; line < height; line++) {
    let at = line * row + field.offset;
    for (let i = 0; i < width; i++, at += step) found[count++] = read(view, at, little);
  }
  return found;
}

/** Colours lie in the four bytes of a number: blue, green, red. */
function coloursOf({ view, little, width, height, step, row }: Layout, fields: readonly PointField[]): Uint8Array | null {
  const field = fields.find(({ name }) => name === "rgb" || name === "rgba");
  if (field === undefined || field.offset + 4 > step) return null;
  const found = new Uint8Array(width * height * 3);
  let count = 0;
  for (let line = 0; line < height; line++) {
    let at = line * row + field.offset;
    for (let i = 0; i < width; i++, at += step) {
      const packedColour = view.getUint32(at, little);
      found[count++] = (packedColour >> 16) & 255;
      found[count++] = (packedColour >> 8) & 255;
      found[count++] = packedColour & 255;
    }
  }
  return found;
}

/** Leaves out points that are nowhere: what a depth camera did not see is NaN. */
function packed(
  x: Float32Array,
  y: Float32Array,
  z: Float32Array,
  strength: Float32Array | null,
  colours: Uint8Array | null,
): Pick<PointCloud, "positions" | "intensity" | "rgb"> {
  const positions = new Float32Array(x.length * 3);
  const intensity = strength === null ? null : new Float32Array(x.length);
  const rgb = colours === null ? null : new Uint8Array(x.length * 3);
  let count = 0;
  for (let i = 0; i < x.length; i++) {
    const sum = (x[i] ?? 0) + (y[i] ?? 0) + (z[i] ?? 0);
    if (!Number.isFinite(sum)) continue;
    positions[3 * count] = x[i] ?? 0;
    positions[3 * count + 1] = y[i] ?? 0;
    positions[3 * count + 2] = z[i] ?? 0;
    if (intensity !== null) intensity[count] = strength?.[i] ?? 0;
    if (rgb !== null && colours !== null) for (let part = 0; part < 3; part++) rgb[3 * count + part] = colours[3 * i + part] ?? 0;
    count++;
  }
  return {
    positions: positions.subarray(0, 3 * count),
    intensity: intensity === null ? null : spread(intensity.subarray(0, count)),
    rgb: rgb === null ? null : rgb.subarray(0, 3 * count),
  };
}

/** From the least to the greatest, as 0 to 1. */
export function spread(values: Float32Array): Float32Array {
  let least = Infinity;
  let most = -Infinity;
  for (const value of values) {
    if (value < least) least = value;
    if (value > most) most = value;
  }
  const size = most - least;
  return values.map((value) => (size > 0 ? (value - least) / size : 0.5));
}
