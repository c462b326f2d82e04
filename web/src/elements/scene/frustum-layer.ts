/** A camera's frustum with its newest picture on the plane ahead of it. The object stays from picture to picture: only what is new goes to the graphics hardware. */

import { BufferAttribute, BufferGeometry, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, SRGBColorSpace, Texture, type Object3D } from "three";
import { isCalibrated, picturePlane, planeKey, type PicturePlane } from "../../scene/camera-model.js";
import type { LayerContent, ScenePicture } from "../../scene/scene-model.js";
import type { Vector } from "../../scene/transform.js";
import type { SceneColours } from "./drawing.js";

export type CameraContent = Extract<LayerContent, { readonly shape: "camera" }>;
type FrustumPaints = Pick<SceneColours, "accent" | "night">;

/** How far ahead of its camera a picture stands (m). */
const AHEAD = 0.6;
/** What is older (ms) than this is not what the camera sees now, and fades. */
const OLD_MS = 2000;
const FADED = 0.3;

interface FrustumParts {
  readonly key: string;
  readonly plane: Mesh<BufferGeometry, MeshBasicMaterial>;
  heardMs: number;
}

export function drawFrustum(content: CameraContent, paints: FrustumPaints): Group {
  const group = new Group();
  if (!isCalibrated(content.info)) return group;
  const found = picturePlane(content.info, AHEAD);
  const lines = new BufferGeometry().setAttribute("position", new BufferAttribute(outline(found), 3));
  const plane = new Mesh(planeGeometry(found), new MeshBasicMaterial({ side: DoubleSide, toneMapped: false, transparent: true, color: paints.night ? 0xff0000 : 0xffffff }));
  for (const object of [new LineSegments(lines, new LineBasicMaterial({ color: paints.accent })), plane]) {
    object.frustumCulled = false;
    group.add(object);
  }
  const parts: FrustumParts = { key: planeKey(content.info), plane, heardMs: -Infinity };
  group.userData["frustum"] = parts;
  writePicture(parts, content.picture);
  return group;
}

/** Puts another picture where the one before was; false where the object shows something else. */
export function redrawFrustum(object: Object3D, content: LayerContent): boolean {
  const parts = partsOf(object);
  if (parts === null || content.shape !== "camera" || parts.key !== planeKey(content.info)) return false;
  writePicture(parts, content.picture);
  return true;
}

/** What has grown old meanwhile is shown so, and what is of a later moment than the one that is shown. */
export function fadeFrustum(object: Object3D, nowMs: number): void {
  const parts = partsOf(object);
  if (parts !== null) parts.plane.material.opacity = Math.abs(nowMs - parts.heardMs) > OLD_MS ? FADED : 1;
}

/** What shows the picture; null of what is no frustum. */
export function picturePart(object: Object3D): Object3D | null {
  return partsOf(object)?.plane ?? null;
}

function partsOf(object: Object3D): FrustumParts | null {
  return (object.userData["frustum"] as FrustumParts | undefined) ?? null;
}

function writePicture(parts: FrustumParts, picture: ScenePicture | null): void {
  const { material } = parts.plane;
  parts.plane.visible = picture !== null;
  if (picture === null) return;
  parts.heardMs = picture.heardMs;
  const before = material.map;
  if (before?.image === picture.image) return;
  // What lies on the hardware has one size.
  const fits = before !== null && sizeOf(before) === `${String(picture.image.width)}x${String(picture.image.height)}`;
  if (!fits) before?.dispose();
  const texture = fits ? before : new Texture();
  texture.image = picture.image;
  texture.colorSpace = SRGBColorSpace;
  texture.generateMipmaps = false;
  texture.userData["size"] = `${String(picture.image.width)}x${String(picture.image.height)}`;
  // Its rows count from above, and so do the parts of the plane.
  texture.flipY = false;
  texture.needsUpdate = true;
  if (fits) return;
  material.map = texture;
  material.needsUpdate = true;
}

function sizeOf(texture: Texture): unknown {
  return texture.userData["size"];
}

function planeGeometry({ positions, parts, triangles }: PicturePlane): BufferGeometry {
  return new BufferGeometry()
    .setAttribute("position", new BufferAttribute(positions, 3))
    .setAttribute("uv", new BufferAttribute(parts, 2))
    .setIndex(new BufferAttribute(triangles, 1));
}

/** From the camera to each corner, and from corner to corner. */
function outline({ corners }: PicturePlane): Float32Array {
  const eye: Vector = [0, 0, 0];
  return new Float32Array(corners.flatMap((corner, at) => [...eye, ...corner, ...corner, ...(corners[(at + 1) % 4] ?? corner)]));
}
