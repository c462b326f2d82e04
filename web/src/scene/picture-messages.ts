/** Pictures of cameras as raw topics carry them, and which of them a camera's calibration speaks of. Pure. */

import { msg, str } from "@lit/localize";
import { MessageError, type MessageReader } from "./cdr.js";
import { readHeader, type MessageHeader } from "./messages.js";

/** A picture that a browser can decode by itself. */
export interface PackedPicture extends MessageHeader {
  readonly form: "packed";
  /** `image/jpeg` or `image/png` */
  readonly mime: string;
  readonly data: Uint8Array;
}

/** A picture pixel by pixel: red, green, blue, opacity. */
export interface PlainPicture extends MessageHeader {
  readonly form: "plain";
  readonly width: number;
  readonly height: number;
  readonly pixels: Uint8ClampedArray<ArrayBuffer>;
}

/** Where the pictures of a calibrated camera come from. */
export type PictureSource = StreamSource | TopicSource;

interface StreamSource {
  readonly from: "stream";
  /** `device/stream` */
  readonly stream: string;
  /** What stands in its place where it has no pictures, such as at a moment without a film. */
  readonly beside: TopicSource | null;
}

interface TopicSource {
  readonly from: "topic";
  readonly topic: string;
  readonly packed: boolean;
  readonly rectified: boolean;
}

interface ListedTopic {
  readonly topic: string;
  readonly type: string;
  readonly problem: string;
  readonly camera?: string;
}

const PACKED = "sensor_msgs/msg/CompressedImage";
const PLAIN = "sensor_msgs/msg/Image";
const PACKED_NAME = "/compressed";
/** Pixels along a side; more no camera of a robot sends. */
const MOST_SIDE = 16_384;

/** Of the pictures beside a calibration, by ROS's convention in the same namespace, those that cost the line least; null: there are none that one may have. */
export function choosePicture(info: ListedTopic, topics: readonly ListedTopic[]): PictureSource | null {
  const beside = chooseTopic(info, topics);
  return info.camera === undefined || info.camera === "" ? beside : { from: "stream", stream: info.camera, beside };
}

function chooseTopic(info: ListedTopic, topics: readonly ListedTopic[]): TopicSource | null {
  const space = spaceOf(info.topic);
  const beside = topics.filter(({ topic, type, problem }) => problem === "" && (type === PACKED || type === PLAIN) && pictureSpace(topic) === space);
  const found = beside.find(({ type }) => type === PACKED) ?? beside[0];
  return found === undefined ? null : { from: "topic", topic: found.topic, packed: found.type === PACKED, rectified: /(^|[/_])rect/.test(found.topic) };
}

/** The namespace of a picture's topic; what image_transport makes of a topic has that topic's. */
function pictureSpace(topic: string): string {
  return spaceOf(topic.endsWith(PACKED_NAME) ? topic.slice(0, -PACKED_NAME.length) : topic);
}

function spaceOf(topic: string): string {
  return topic.slice(0, Math.max(0, topic.lastIndexOf("/")));
}

/** `sensor_msgs/msg/CompressedImage` */
export function readPackedPicture(reader: MessageReader): PackedPicture {
  const header = readHeader(reader);
  reader.text();
  const data = reader.octets();
  // The text beside it says what it was before, and not always what it is.
  const mime = data[0] === 0xff && data[1] === 0xd8 ? "image/jpeg" : data[0] === 0x89 && data[1] === 0x50 ? "image/png" : "";
  if (mime === "") throw new MessageError(msg("a picture that is neither JPEG nor PNG"));
  return { ...header, form: "packed", mime, data };
}

/** Where the parts of a pixel lie (bytes): red, green, blue; and how many bytes it has. */
const LAYOUTS: Readonly<Record<string, readonly [red: number, green: number, blue: number, size: number]>> = {
  rgb8: [0, 1, 2, 3],
  bgr8: [2, 1, 0, 3],
  "8UC3": [2, 1, 0, 3],
  rgba8: [0, 1, 2, 4],
  bgra8: [2, 1, 0, 4],
  "8UC4": [2, 1, 0, 4],
  mono8: [0, 0, 0, 1],
  "8UC1": [0, 0, 0, 1],
};
/** Of one number for each pixel, shown from its least to its greatest: bytes of it, and how it is read. */
const NUMBERS: Readonly<Record<string, readonly [size: number, read: (view: DataView, at: number, little: boolean) => number]>> = {
  mono16: [2, (view, at, little) => view.getUint16(at, little)],
  "16UC1": [2, (view, at, little) => view.getUint16(at, little)],
  "32FC1": [4, (view, at, little) => view.getFloat32(at, little)],
};

/** `sensor_msgs/msg/Image` */
export function readPlainPicture(reader: MessageReader): PlainPicture {
  const header = readHeader(reader);
  const height = reader.uint32();
  const width = reader.uint32();
  const encoding = reader.text();
  const little = !reader.bool();
  const step = reader.uint32();
  const data = reader.octets();
  const size = LAYOUTS[encoding]?.[3] ?? NUMBERS[encoding]?.[0];
  if (size === undefined) throw new MessageError(msg(str`pictures as ${encoding} are not shown`));
  if (width < 1 || height < 1 || width > MOST_SIDE || height > MOST_SIDE || step < width * size || data.length < height * step) throw new MessageError(msg("a picture whose sizes do not fit"));
  const pixels = new Uint8ClampedArray(4 * width * height).fill(255);
  const layout = LAYOUTS[encoding];
  const number = NUMBERS[encoding];
  if (layout !== undefined) copyColours({ width, height, step, data }, layout, pixels);
  else if (number !== undefined) spreadNumbers({ width, height, step, data }, (view, at) => number[1](view, at, little), size, pixels);
  return { ...header, form: "plain", width, height, pixels };
}

interface Rows {
  readonly width: number;
  readonly height: number;
  readonly step: number;
  readonly data: Uint8Array;
}

function copyColours({ width, height, step, data }: Rows, [red, green, blue, size]: readonly [number, number, number, number], pixels: Uint8ClampedArray): void {
  let to = 0;
  for (let row = 0; row < height; row++) {
    for (let column = 0, at = row * step; column < width; column++, at += size, to += 4) {
      pixels[to] = data[at + red] ?? 0;
      pixels[to + 1] = data[at + green] ?? 0;
      pixels[to + 2] = data[at + blue] ?? 0;
    }
  }
}

/** Depths, say: near is dark. What is nothing is black. */
function spreadNumbers({ width, height, step, data }: Rows, read: (view: DataView, at: number) => number, size: number, pixels: Uint8ClampedArray): void {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  const values = new Float32Array(width * height);
  let [least, most] = [Infinity, -Infinity];
  for (let row = 0, at = 0; row < height; row++) {
    for (let column = 0; column < width; column++, at++) {
      const value = read(view, row * step + column * size);
      values[at] = value;
      if (!Number.isFinite(value)) continue;
      least = Math.min(least, value);
      most = Math.max(most, value);
    }
  }
  const scale = most > least ? 255 / (most - least) : 0;
  values.forEach((value, at) => {
    pixels.fill(Number.isFinite(value) ? (value - least) * scale : 0, 4 * at, 4 * at + 3);
  });
}
