/** What one topic shows, as an object of three.js; made anew when another message has come. */

import {
  BoxGeometry, BufferAttribute, BufferGeometry, Color, CylinderGeometry, DataTexture, DoubleSide, Group, InstancedMesh, Line, LineBasicMaterial,
  LineSegments, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, NearestFilter, Object3D, PlaneGeometry, Points, PointsMaterial,
  SphereGeometry, SRGBColorSpace, type Material,
} from "three";
import type { Marker } from "../../scene/markers.js";
import type { OccupancyGrid } from "../../scene/messages.js";
import type { LayerContent } from "../../scene/scene-model.js";
import type { Transform, Vector } from "../../scene/transform.js";
import type { SceneColours, SceneOptions } from "./drawing.js";
import { drawFrustum } from "./frustum-layer.js";
import { gridPixels } from "./grid-pixels.js";
import { drawPoints } from "./point-layer.js";

type Paints = SceneColours & Pick<SceneOptions, "cloudBy">;

const ARROW = 0.3;
/** Entries of a list of cubes or spheres that are drawn. */
const MOST_INSTANCES = 20_000;

export function drawLayer(content: LayerContent, paints: Paints): Object3D {
  switch (content.shape) {
    case "scan":
    case "cloud":
      return drawPoints(content, paints);
    case "grid":
      return drawGrid(content.grid, paints);
    case "line":
      return new Line(geometryOf(flat(content.points)), new LineBasicMaterial({ color: paints.path }));
    case "poses":
      return new LineSegments(geometryOf(flat(content.poses.flatMap(arrowLines))), new LineBasicMaterial({ color: paints.poses }));
    case "camera":
      return drawFrustum(content, paints);
    case "markers": {
      const group = new Group();
      for (const { marker } of content.markers) {
        const drawn = drawMarker(marker, paints.night);
        if (drawn !== null) group.add(drawn);
      }
      return group;
    }
  }
}

/** Gives back what the graphics hardware holds of an object. */
export function disposeObject(object: Object3D): void {
  object.traverse((part) => {
    const { geometry, material: materials } = part as Partial<Mesh>;
    geometry?.dispose();
    for (const material of [materials ?? []].flat()) {
      (material as Material & { readonly map?: DataTexture | null }).map?.dispose();
      material.dispose();
    }
  });
}

function geometryOf(positions: Float32Array): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  return geometry;
}

function flat(points: readonly Vector[]): Float32Array {
  return new Float32Array(points.flat());
}

/** An arrow along x: its shaft and its two barbs, in pairs of points. */
function arrowLines({ at, turn }: Transform): Vector[] {
  const object = new Object3D();
  object.position.set(...at);
  object.quaternion.set(...turn);
  object.updateMatrix();
  const point = (x: number, y: number): Vector => {
    const matrix = object.matrix.elements;
    const along = (row: number): number => (matrix[row] ?? 0) * x + (matrix[row + 4] ?? 0) * y + (matrix[row + 12] ?? 0);
    return [along(0), along(1), along(2)];
  };
  const [tail, tip] = [point(0, 0), point(ARROW, 0)];
  return [tail, tip, tip, point(0.7 * ARROW, 0.2 * ARROW), tip, point(0.7 * ARROW, -0.2 * ARROW)];
}

function drawGrid(grid: OccupancyGrid, paints: Paints): Object3D {
  const { width, height, resolution, origin, cells } = grid;
  const group = new Group();
  if (width * height === 0 || cells.length < width * height) return group;
  const texture = new DataTexture(gridPixels(grid, paints), width, height);
  texture.magFilter = NearestFilter;
  texture.minFilter = NearestFilter;
  texture.colorSpace = SRGBColorSpace;
  texture.needsUpdate = true;
  const floor = new Mesh(new PlaneGeometry(width * resolution, height * resolution), new MeshBasicMaterial({ map: texture, transparent: true, side: DoubleSide, depthWrite: false }));
  // A plane's own origin is in its middle, a map's in its corner.
  // A hair below the floor's lines, so that these are seen whole.
  floor.position.set((width * resolution) / 2, (height * resolution) / 2, -0.005);
  floor.renderOrder = -1;
  const placed = new Group();
  placed.add(floor);
  placed.position.set(...origin.at);
  placed.quaternion.set(...origin.turn);
  group.add(placed);
  return group;
}

function drawMarker(marker: Marker, night: boolean): Object3D | null {
  const made = markerShape(marker, night);
  if (made === null) return null;
  // Its own frame is applied by whoever places it.
  made.userData["marker"] = marker;
  return made;
}

function markerShape(marker: Marker, night: boolean): Object3D | null {
  const [r, g, b, opacity] = marker.colour;
  const color = night ? new Color(Math.max(r, g, b), 0, 0) : new Color(r, g, b);
  const solid = new MeshLambertMaterial({ color, opacity, transparent: opacity < 1 });
  const [x, y, z] = marker.scale;
  const points = flat(marker.points);
  switch (marker.kind) {
    case "cube":
      return new Mesh(new BoxGeometry(x, y, z), solid);
    case "sphere": {
      const ball = new Mesh(new SphereGeometry(0.5, 20, 14), solid);
      ball.geometry.scale(x, y, z);
      return ball;
    }
    case "cylinder": {
      const tube = new Mesh(new CylinderGeometry(0.5, 0.5, 1, 24), solid);
      tube.geometry.rotateX(Math.PI / 2).scale(x, y, z);
      return tube;
    }
    case "arrow": {
      const [from, to] = marker.points;
      const line = from && to ? flat([from, to]) : new Float32Array([0, 0, 0, x, 0, 0]);
      return new Line(geometryOf(line), new LineBasicMaterial({ color }));
    }
    case "line strip":
      return new Line(geometryOf(points), new LineBasicMaterial({ color }));
    case "line list":
      return new LineSegments(geometryOf(points), new LineBasicMaterial({ color }));
    case "points":
      return new Points(geometryOf(points), new PointsMaterial({ color, size: Math.max(x, 0.01) }));
    case "triangles": {
      const geometry = geometryOf(points);
      geometry.computeVertexNormals();
      return new Mesh(geometry, solid);
    }
    case "cube list":
      return instances(new BoxGeometry(x, y, z), solid, marker.points);
    case "sphere list":
      return instances(new SphereGeometry(x / 2, 12, 8), solid, marker.points);
    case "text":
    case "mesh":
    case null:
      return null;
  }
}

function instances(geometry: BufferGeometry, material: Material, points: readonly Vector[]): Object3D {
  const shown = points.slice(0, MOST_INSTANCES);
  const many = new InstancedMesh(geometry, material, shown.length);
  shown.forEach(([x, y, z], at) => {
    many.setMatrixAt(at, new Matrix4().makeTranslation(x, y, z));
  });
  return many;
}
