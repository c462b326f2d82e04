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
  const floats = floatsOf(layout);
  const columnOf = (name: string): Column | null => columnIn(floats, layout, fields.find((field) => field.name === name), name);
  const [x, y, z] = [columnOf("x"), columnOf("y"), columnOf("z")];
  if (!x || !y || !z) throw new MessageError(msg("a cloud whose points have no x, y and z"));
  return { ...header, ...packed(width * height, [x, y, z], columnOf("intensity"), coloursOf(layout, fields)) };
}

/** One number of each point: the first stands at `first`, and `stride` on the next. */
interface Column {
  readonly values: Float32Array;
  readonly first: number;
  readonly stride: number;
}

const FLOAT32 = 7;
const LITTLE = new Uint8Array(new Uint16Array([1]).buffer)[0] === 1;

/** The points as floats, where they lie so that they can be read as such: one by one would take ten times as long. */
function floatsOf({ view, little, width, height, step, row }: Layout): Float32Array | null {
  if (little !== LITTLE || step % 4 !== 0 || (height > 1 && row !== width * step)) return null;
  const begin = view.byteOffset;
  return new Float32Array(view.buffer.slice(begin, begin + width * height * step));
}

function columnIn(floats: Float32Array | null, layout: Layout, field: PointField | undefined, name: string): Column | null {
  const plain = field?.datatype === FLOAT32 && field.offset % 4 === 0 && field.offset + 4 <= layout.step;
  if (floats !== null && plain) return { values: floats, first: field.offset / 4, stride: layout.step / 4 };
  const values = valuesOf(layout, field, name);
  return values === null ? null : { values, first: 0, stride: 1 };
}

interface Layout {
  readonly view: DataView;
  readonly little: boolean;
  readonly width: number;
  readonly height: number;
  readonly step: number;
  readonly row: number;
}

function valuesOf({ view, little, width, height, step, row }: Layout, field: PointField | undefined, name: string): Float32Array | null {
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
  points: number,
  [xs, ys, zs]: readonly [Column, Column, Column],
  strength: Column | null,
  colours: Uint8Array | null,
): Pick<PointCloud, "positions" | "intensity" | "rgb"> {
  const positions = new Float32Array(points * 3);
  const intensity = strength === null ? null : new Float32Array(points);
  const rgb = colours === null ? null : new Uint8Array(points * 3);
  let count = 0;
  for (let i = 0; i < points; i++) {
    const x = xs.values[xs.first + i * xs.stride] ?? 0;
    const y = ys.values[ys.first + i * ys.stride] ?? 0;
    const z = zs.values[zs.first + i * zs.stride] ?? 0;
    if (!Number.isFinite(x + y + z)) continue;
    positions[3 * count] = x;
    positions[3 * count + 1] = y;
    positions[3 * count + 2] = z;
    if (intensity !== null && strength !== null) intensity[count] = strength.values[strength.first + i * strength.stride] ?? 0;
    if (rgb !== null && colours !== null) for (let part = 0; part < 3; part++) rgb[3 * count + part] = colours[3 * i + part] ?? 0;
    count++;
  }
  return {
    positions: positions.subarray(0, 3 * count),
    intensity: intensity === null ? null : spread(intensity.subarray(0, count)),
    rgb: rgb === null ? null : rgb.subarray(0, 3 * count),
  };
}

/** The least and the greatest of every `stride`-th value. */
export function spanOf(values: Float32Array, first: number, stride: number): readonly [least: number, most: number] {
  let least = Infinity;
  let most = -Infinity;
  for (let at = first; at < values.length; at += stride) {
    const value = values[at] ?? 0;
    if (value < least) least = value;
    if (value > most) most = value;
  }
  return [least, most];
}

/** From the least to the greatest, as 0 to 1; in the same array. */
function spread(values: Float32Array): Float32Array {
  const [least, most] = spanOf(values, 0, 1);
  const size = most - least;
  for (let i = 0; i < values.length; i++) values[i] = size > 0 ? ((values[i] ?? 0) - least) / size : 0.5;
  return values;
}
