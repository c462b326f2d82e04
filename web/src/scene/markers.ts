/** `visualization_msgs` markers. Pure. */

import type { MessageReader } from "./cdr.js";
import { readHeader, readPose, readVector, type MessageHeader } from "./messages.js";
import type { Transform, Vector } from "./transform.js";

/** By the numbers of `Marker.type`. */
export const MARKER_KINDS = [
  "arrow", "cube", "sphere", "cylinder", "line strip", "line list", "cube list", "sphere list", "points", "text", "mesh", "triangles",
] as const;
export type MarkerKind = (typeof MARKER_KINDS)[number];

export interface Marker extends MessageHeader {
  readonly key: string;
  readonly kind: MarkerKind | null;
  readonly action: "set" | "remove" | "remove all";
  readonly pose: Transform;
  readonly scale: Vector;
  /** Red, green, blue, opacity: 0 to 1. */
  readonly colour: readonly [number, number, number, number];
  /** It goes by itself after so long (ms); 0: it stays. */
  readonly lifetimeMs: number;
  readonly points: readonly Vector[];
  readonly colours: readonly (readonly [number, number, number, number])[];
  readonly text: string;
}

const POINT = 24;
const COLOUR = 16;
const LEAST_MARKER = 120;

function readColour(reader: MessageReader): readonly [number, number, number, number] {
  return [reader.float32(), reader.float32(), reader.float32(), reader.float32()];
}

export function readMarker(reader: MessageReader): Marker {
  const header = readHeader(reader);
  const key = `${reader.text()}/${String(reader.int32())}`;
  const kind = MARKER_KINDS[reader.int32()] ?? null;
  const action = reader.int32();
  const pose = readPose(reader);
  const scale = readVector(reader);
  const colour = readColour(reader);
  const lifetimeMs = reader.int32() * 1000 + reader.uint32() / 1e6;
  reader.bool();
  const points = reader.list(POINT, () => readVector(reader));
  const colours = reader.list(COLOUR, () => readColour(reader));
  if (!reader.ros1) {
    // Its texture: a name, a picture, and where it lies.
    reader.text();
    readHeader(reader);
    reader.text();
    reader.octets();
    reader.list(8, () => [reader.float32(), reader.float32()]);
  }
  const text = reader.text();
  reader.text();
  if (!reader.ros1) {
    reader.text();
    reader.octets();
  }
  reader.bool();
  return { ...header, key, kind, action: action === 2 ? "remove" : action === 3 ? "remove all" : "set", pose, scale, colour, lifetimeMs, points, colours, text };
}

export function readMarkers(reader: MessageReader): Marker[] {
  return reader.list(LEAST_MARKER, () => readMarker(reader));
}
