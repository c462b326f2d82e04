/** Zones and lines of a camera as a person draws them, and as the site's description has them. Pure. */

import { msg, str } from "@lit/localize";
import type { PicturePoint } from "../../elements/camera/mark-shapes.js";
import { changedAt, freeName, isObject, valueAt, type Json, type JsonObject } from "../description/json-schema.js";

export type ShapeKind = "zone" | "line";

/** A zone or a line, with what is counted at it. */
export interface DrawnShape {
  readonly kind: ShapeKind;
  /** Its key in the description; empty for one that was drawn now and has none yet. */
  readonly id: string;
  readonly name: string;
  readonly points: readonly PicturePoint[];
  /** Class that a signal counts at it; empty where none is to be made. */
  readonly counts: string;
}

/** How many corners a zone, and how many points a line has at the least and at the most. */
export const LEAST_POINTS: Readonly<Record<ShapeKind, number>> = { zone: 3, line: 2 };
export const MOST_POINTS = 64;
export const MOST_EACH = 32;
/** So fine is a place written: a thousandth of the picture is about a pixel. */
const FINE = 1000;
const MEASURES: Readonly<Record<ShapeKind, readonly (readonly [measure: string, word: string])[]>> = {
  zone: [["count", ""], ["dwell", "longest"]],
  line: [["left", msg("to the left")], ["right", msg("to the right")]],
};

/** A place on the picture, and not beside it. */
export function placedPoint(x: number, y: number): PicturePoint {
  const part = (value: number): number => Math.min(1, Math.max(0, value));
  return [part(x), part(y)];
}

/** A new shape in the middle of the picture, where it can be seen and dragged. */
export function newShape(kind: ShapeKind, counts: string, others: readonly DrawnShape[]): DrawnShape {
  // Each a little lower, so that two new ones do not hide each other.
  const many = others.filter((shape) => shape.kind === kind).length;
  const at = 0.35 + 0.05 * (many % 6);
  const points: PicturePoint[] =
    kind === "zone"
      ? [placedPoint(0.35, at), placedPoint(0.65, at), placedPoint(0.7, at + 0.3), placedPoint(0.3, at + 0.3)]
      : [placedPoint(0.3, at + 0.15), placedPoint(0.7, at + 0.15)];
  const named = (number: number): string => (kind === "zone" ? msg(str`Zone ${String(number)}`) : msg(str`Line ${String(number)}`));
  const names = new Set(others.map(({ name }) => name));
  let number = many + 1;
  while (names.has(named(number))) number += 1;
  return { kind, id: "", name: named(number), points, counts };
}

export function movedPoint(shape: DrawnShape, index: number, to: PicturePoint): DrawnShape {
  return { ...shape, points: shape.points.map((point, at) => (at === index ? placedPoint(...to) : point)) };
}

/** All of it, as far as it stays on the picture. */
export function movedShape(shape: DrawnShape, dx: number, dy: number): DrawnShape {
  const xs = shape.points.map(([x]) => x);
  const ys = shape.points.map(([, y]) => y);
  const clampedStep = (step: number, parts: readonly number[]): number => Math.min(1 - Math.max(...parts), Math.max(-Math.min(...parts), step));
  const [byX, byY] = [clampedStep(dx, xs), clampedStep(dy, ys)];
  return { ...shape, points: shape.points.map(([x, y]) => placedPoint(x + byX, y + byY)) };
}

/** With one more point in the middle of the way from `index` to the next. */
export function withPointAfter(shape: DrawnShape, index: number): DrawnShape {
  const { points } = shape;
  const from = points[index];
  const to = points[(index + 1) % points.length];
  if (from === undefined || to === undefined || points.length >= MOST_POINTS) return shape;
  const middle = placedPoint((from[0] + to[0]) / 2, (from[1] + to[1]) / 2);
  return { ...shape, points: [...points.slice(0, index + 1), middle, ...points.slice(index + 1)] };
}

/** Without a point; the same where it would be no zone or line any more. */
export function withoutPoint(shape: DrawnShape, index: number): DrawnShape {
  if (shape.points.length <= LEAST_POINTS[shape.kind]) return shape;
  return { ...shape, points: shape.points.filter((_, at) => at !== index) };
}

/** A line the other way round: its left is its right then. */
export function reversedShape(shape: DrawnShape): DrawnShape {
  return { ...shape, points: [...shape.points].reverse() };
}

/** The points between which one can be added: after each, but after the last of a line. */
export function gapsOf(shape: DrawnShape): readonly { readonly after: number; readonly at: PicturePoint }[] {
  const { points } = shape;
  const many = shape.kind === "zone" ? points.length : points.length - 1;
  if (points.length >= MOST_POINTS) return [];
  return points.slice(0, many).map(([x, y], after) => {
    const [toX, toY] = points[(after + 1) % points.length] ?? [x, y];
    return { after, at: [(x + toX) / 2, (y + toY) / 2] };
  });
}

// ── in the description ──

/** What a camera's description has of zones and lines, in its order. */
export function readShapes(described: JsonObject, camera: string): DrawnShape[] {
  const detect = valueAt(described, detectPath(camera));
  return (["zone", "line"] as const).flatMap((kind) => {
    const things = valueAt(detect, [`${kind}s`]);
    return Object.entries(isObject(things) ? things : {}).flatMap(([id, thing]) => {
      if (!isObject(thing)) return [];
      const points = Array.isArray(thing["points"]) ? (thing["points"] as readonly Json[]) : [];
      const name = typeof thing["name"] === "string" ? thing["name"] : id;
      return [{ kind, id, name, points: points.flatMap(readPoint), counts: "" }];
    });
  });
}

/** The description with these zones and lines instead of the camera's own, and with signals that count at new ones. */
export function withShapes(described: JsonObject, camera: string, shapes: readonly DrawnShape[]): JsonObject {
  const kept = new Set<string>();
  let signals: Json = {};
  let made = described;
  const [device = "", stream = ""] = camera.split("/");
  for (const kind of ["zone", "line"] as const) {
    const things: Record<string, Json> = {};
    for (const shape of shapes.filter((drawn) => drawn.kind === kind)) {
      const id = shape.id === "" ? freeName(things, idOf(shape.name, kind, shapes)) : shape.id;
      things[id] = { name: shape.name.trim(), points: shape.points.map(([x, y]) => [roundedPart(x), roundedPart(y)]) };
      kept.add(`${kind}/${id}`);
      if (shape.counts !== "") signals = { ...signals, ...signalsAt(kind, id, shape, stream) };
    }
    const path = [...detectPath(camera), `${kind}s`];
    if (Object.keys(things).length > 0 || valueAt(described, path) !== undefined) made = changedAt(made, path, things);
  }
  return withSignals(made, { device, stream, kept, added: signals });
}

interface CountingSignals {
  readonly device: string;
  readonly stream: string;
  /** `zone/mat`, of what is still there. */
  readonly kept: ReadonlySet<string>;
  readonly added: JsonObject;
}

/** What counts at a shape that is gone goes with it; the gateway would refuse a zone that nobody knows. */
function withSignals(described: JsonObject, { device, stream, kept, added }: CountingSignals): JsonObject {
  const path = ["devices", device, "signals"];
  const before = valueAt(described, path);
  const all = isObject(before) ? before : {};
  const left = Object.fromEntries(Object.entries(all).filter(([, signal]) => !countsAtGone(valueAt(signal, ["source"]), stream, kept)));
  let signals: JsonObject = left;
  for (const [id, signal] of Object.entries(added)) signals = { ...signals, [freeName(signals, id)]: signal };
  const same = Object.keys(left).length === Object.keys(all).length && Object.keys(added).length === 0;
  return same ? described : changedAt(described, path, signals);
}

function countsAtGone(source: Json | undefined, stream: string, kept: ReadonlySet<string>): boolean {
  if (!isObject(source) || source["stream"] !== stream) return false;
  return (["zone", "line"] as const).some((kind) => {
    const at = source[kind];
    return typeof at === "string" && at !== "" && !kept.has(`${kind}/${at}`);
  });
}

/** The signals that go with a shape that is to count: who is in a zone and for how long, who crosses a line to either side. */
function signalsAt(kind: ShapeKind, id: string, shape: DrawnShape, stream: string): JsonObject {
  return Object.fromEntries(
    MEASURES[kind].map(([measure, word]) => {
      const source: JsonObject = { stream, sees: shape.counts, [kind]: id, ...(measure === "count" ? {} : { measure }) };
      const name = `${shape.name.trim()}: ${shape.counts}${word === "" ? "" : `, ${word}`}`;
      return [`${id}_${measure}`, { name, ...(measure === "dwell" ? { unit: "s" } : {}), source }];
    }),
  );
}

/** The key of a new shape, from its name; unlike those that others of the camera have. */
function idOf(name: string, kind: ShapeKind, shapes: readonly DrawnShape[]): string {
  const word = name.toLowerCase().replaceAll(/[^a-z0-9]+/g, "_").replaceAll(/^[^a-z]+|_+$/g, "").slice(0, 40) || kind;
  return freeName(Object.fromEntries(shapes.map(({ id }) => [id, null])), word);
}

function detectPath(camera: string): readonly string[] {
  const [device = "", stream = ""] = camera.split("/");
  return ["devices", device, "streams", stream, "detect"];
}

/** Only when it is written: a slow drag is many steps, each of which rounding would swallow. */
function roundedPart(value: number): number {
  return Math.round(value * FINE) / FINE;
}

function readPoint(point: Json): PicturePoint[] {
  if (!Array.isArray(point)) return [];
  const [x, y] = point as readonly Json[];
  return typeof x === "number" && typeof y === "number" ? [[x, y]] : [];
}
