/**
 * Points of a scan or a cloud. The object stays the same from message to message: what is made anew for each has its
 * shader compiled and its memory taken anew, ten times a second.
 */

import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Points, PointsMaterial, type Object3D } from "three";
import { cloudColours } from "../../scene/colours.js";
import type { LayerContent } from "../../scene/scene-model.js";
import type { SceneColours, SceneOptions } from "./drawing.js";

export type PointContent = Extract<LayerContent, { readonly shape: "scan" | "cloud" }>;
type PointPaints = Pick<SceneColours, "scan" | "night"> & Pick<SceneOptions, "cloudBy">;

/** A scan's and a cloud's points (px). */
const SCAN_PX = 4;
const CLOUD_PX = 2;
/** More room than is needed now: a scan has a few points more or less each time. */
const ROOM = 1.25;

export function drawPoints(content: PointContent, paints: PointPaints): Points {
  const look = content.shape === "scan" ? { color: paints.scan, size: SCAN_PX } : { vertexColors: true, size: CLOUD_PX };
  const points = new Points(new BufferGeometry(), new PointsMaterial({ ...look, sizeAttenuation: false }));
  points.userData["shape"] = content.shape;
  writePoints(points.geometry, content, paints);
  return points;
}

/** Puts another message's points into what was drawn; false where that shows something else. */
export function redrawPoints(object: Object3D, content: LayerContent, paints: PointPaints): boolean {
  if (!(object instanceof Points) || (content.shape !== "scan" && content.shape !== "cloud") || object.userData["shape"] !== content.shape) return false;
  writePoints(object.geometry as BufferGeometry, content, paints);
  return true;
}

/** How many points a geometry shows of those that it has room for. */
export function shownCount(geometry: BufferGeometry): number {
  return Math.min(geometry.getAttribute("position").count, geometry.drawRange.count);
}

function writePoints(geometry: BufferGeometry, content: PointContent, paints: PointPaints): void {
  const positions = content.shape === "scan" ? content.positions : content.cloud.positions;
  writeAttribute(geometry, "position", positions, 3);
  if (content.shape === "cloud") writeAttribute(geometry, "color", cloudColours(content.cloud, paints.cloudBy, paints.night), 4);
  geometry.setDrawRange(0, positions.length / 3);
}

/** Bytes are shares of 255. */
function writeAttribute(geometry: BufferGeometry, name: string, values: Float32Array | Uint8Array, size: number): void {
  let attribute = geometry.hasAttribute(name) ? (geometry.getAttribute(name) as BufferAttribute) : null;
  if (attribute === null || attribute.array.length < values.length) {
    // Gives back what the graphics hardware holds; what stays is handed over again.
    geometry.dispose();
    const room = size * Math.ceil((ROOM * values.length) / size);
    attribute = new BufferAttribute(values instanceof Uint8Array ? new Uint8Array(room) : new Float32Array(room), size, values instanceof Uint8Array);
    attribute.setUsage(DynamicDrawUsage);
    geometry.setAttribute(name, attribute);
  }
  attribute.array.set(values);
  attribute.clearUpdateRanges();
  attribute.addUpdateRange(0, values.length);
  attribute.needsUpdate = true;
}
