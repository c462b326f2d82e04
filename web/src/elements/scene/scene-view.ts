/**
 * The scene in space (three.js): loaded when a scene is first shown. It draws when something has changed, and else rests.
 *
 * After each frame `window.__talaiaSceneDrawn(news)` is called where a page has set it, with topic and time (µs) of each
 * layer that was drawn for the first time; the benchmarks do.
 */

import { FrameSchedule } from "../base/frame-schedule.js";
import {
  AmbientLight, ArrowHelper, AxesHelper, BufferAttribute, BufferGeometry, Color, DirectionalLight, GridHelper, Line, LineBasicMaterial, PerspectiveCamera,
  Plane, Raycaster, Scene, Vector2, Vector3, WebGLRenderer, type Object3D,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Marker } from "../../scene/markers.js";
import type { FloorPose } from "../../scene/pose-command.js";
import { changesByItself, type SceneLayer, type SceneModel } from "../../scene/scene-model.js";
import { composed, type Transform, type Vector } from "../../scene/transform.js";
import { sameOptions, type MeasuredLine, type SceneColours, type SceneDrawing, type SceneOptions } from "./drawing.js";
import { fadeFrustum, picturePart, redrawFrustum } from "./frustum-layer.js";
import { disposeObject, drawLayer } from "./layer-drawing.js";
import { MeshStore } from "./meshes.js";
import { MissingMeshes } from "./missing-meshes.js";
import { redrawPoints, shownCount } from "./point-layer.js";
import { GhostModels } from "./ghost-models.js";
import { isSoftware, rendererName } from "./graphics.js";
import { RobotModel } from "./robot-model.js";

declare global {
  interface Window {
    __talaiaSceneDrawn?: (news: readonly SceneNews[]) => void;
  }
}

type SceneNews = readonly [topic: string, timeUs: number];

interface Drawn {
  readonly object: Object3D;
  readonly number: number;
}

const FIELD = 50;
const NEAR = 0.02;
const FAR = 2000;
const START: Vector = [-2.6, -2.6, 3.2];
const GRID_M = 40;

export class SceneView implements SceneDrawing {
  painted = 0;
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(FIELD, 1, NEAR, FAR);
  private readonly sun = new DirectionalLight(0xffffff, 2);
  private readonly sky = new AmbientLight(0xffffff, 1.4);
  private readonly controls: OrbitControls;
  private readonly drawn = new Map<string, Drawn>();
  private readonly meshes: MeshStore;
  private readonly frames = new Map<string, Object3D>();
  private readonly ghosts = new GhostModels(this.scene);
  private robot: RobotModel | null = null;
  private urdf = "";
  private jointsUs = -1;
  private news: SceneNews[] = [];
  private ground: Object3D | null = null;
  private preview: Object3D[] = [];
  private followed: Vector | null = null;
  private colours: SceneColours;
  /** Layers have colours that are not true any more. */
  private repaint = false;
  private readonly painting = new FrameSchedule(() => {
    this.paint();
  });
  private options: SceneOptions = { fixed: "", follow: "", cloudBy: "height", showRobot: true, showFrames: false };

  /** @throws Error when the browser has no WebGL */
  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly model: SceneModel,
    site: string,
    colours: SceneColours,
    private readonly onTrouble: (why: string) => void,
  ) {
    this.renderer = new WebGLRenderer({ canvas, context: openGraphics(canvas) });
    this.meshes = new MeshStore(site, this.schedule);
    // REP-103: z is up.
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(...START);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.listenToKeyEvents(canvas);
    this.controls.maxPolarAngle = Math.PI / 2;
    this.controls.addEventListener("change", this.schedule);
    this.sun.position.set(3, -5, 10);
    this.scene.add(this.sky, this.sun);
    this.colours = colours;
    this.setColours(colours);
  }

  setColours(colours: SceneColours): void {
    this.colours = colours;
    this.repaint = true;
    this.scene.background = new Color(colours.background);
    this.ghosts.setColours(colours);
    // In red light a model is red, whatever its own colours: at night nothing else may shine.
    for (const light of [this.sun, this.sky]) light.color.set(colours.night ? 0xff0000 : 0xffffff);
    if (this.ground !== null) {
      this.scene.remove(this.ground);
      disposeObject(this.ground);
    }
    // A metre between lines; three's grids lie in x and z.
    const ground = new GridHelper(GRID_M, GRID_M, colours.strong, colours.line);
    ground.rotateX(Math.PI / 2);
    this.ground = ground;
    this.scene.add(ground);
    this.schedule();
  }

  /** It is told every second: a picture that would be the same is not drawn, which takes long where a program draws. */
  setOptions(options: SceneOptions): void {
    const same = sameOptions(options, this.options);
    this.repaint ||= options.cloudBy !== this.options.cloudBy;
    this.options = options;
    if (!same || changesByItself(this.model)) this.schedule();
  }

  resize(width: number, height: number, ratio: number): void {
    this.renderer.setPixelRatio(Math.min(ratio, 2));
    this.renderer.setSize(Math.max(1, width), Math.max(1, height), false);
    this.camera.aspect = Math.max(1, width) / Math.max(1, height);
    this.camera.updateProjectionMatrix();
    this.schedule();
  }

  /** Looks from above, or from where it began. */
  lookFrom(where: "above" | "aside"): void {
    const { target } = this.controls;
    const far = this.camera.position.distanceTo(target);
    // Not exactly above: there no side would be up.
    const direction = where === "above" ? new Vector3(-0.001, 0, 1) : new Vector3(...START).normalize();
    this.camera.position.copy(target).addScaledVector(direction, far);
    this.controls.update();
    this.schedule();
  }

  /** Nearer (less than 1) or farther. */
  zoom(factor: number): void {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
    this.schedule();
  }

  /** While a tool is used the pointer does not turn the view. */
  setTool(active: boolean): void {
    this.controls.enableRotate = !active;
    this.controls.enablePan = !active;
  }

  /** Where on the floor (z = 0 of the frame that stands still) a place of the canvas is; null: it looks above the floor. */
  floorAt(x: number, y: number): { readonly x: number; readonly y: number } | null {
    const { clientWidth, clientHeight } = this.canvas;
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2((2 * x) / clientWidth - 1, 1 - (2 * y) / clientHeight), this.camera);
    const hit = ray.ray.intersectPlane(new Plane(new Vector3(0, 0, 1), 0), new Vector3());
    return hit === null ? null : { x: hit.x, y: hit.y };
  }

  /** Where on the canvas (px) a place is. */
  canvasPlace([x, y, z]: Vector): { readonly x: number; readonly y: number } {
    const place = new Vector3(x, y, z).project(this.camera);
    return { x: ((place.x + 1) / 2) * this.canvas.clientWidth, y: ((1 - place.y) / 2) * this.canvas.clientHeight };
  }

  /** An arrow where something is to be, or a line that is measured; null for neither. */
  setPreview(preview: FloorPose | MeasuredLine | null): void {
    for (const object of this.preview.splice(0)) {
      this.scene.remove(object);
      disposeObject(object);
    }
    if (preview !== null) {
      const { accent } = this.colours;
      if ("yaw" in preview) {
        this.preview.push(new ArrowHelper(new Vector3(Math.cos(preview.yaw), Math.sin(preview.yaw), 0), new Vector3(preview.x, preview.y, 0.02), 0.5, accent, 0.16, 0.12));
      } else {
        const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array([...preview.from, ...preview.to]), 3));
        this.preview.push(new Line(geometry, new LineBasicMaterial({ color: accent })));
      }
      this.scene.add(...this.preview);
    }
    this.schedule();
  }

  /** Something has changed: it is drawn with the next frame of the browser, once for all. */
  readonly schedule = (): void => {
    this.painting.schedule();
  };

  /** Frame of the robot's model; empty before there is one. */
  get modelFrame(): string {
    return this.robot?.frame ?? "";
  }

  /** Where a topic's points are in the scene (m), as they are drawn; of a camera those of its picture. */
  pointsOf(topic: string): readonly Vector[] {
    const whole = this.drawn.get(topic)?.object;
    const object = whole === undefined ? undefined : (picturePart(whole) ?? whole);
    const geometry = (object as (Object3D & { readonly geometry?: BufferGeometry }) | undefined)?.geometry;
    const positions = geometry?.getAttribute("position");
    if (object === undefined || geometry === undefined || positions === undefined) return [];
    object.updateWorldMatrix(true, false);
    return Array.from({ length: shownCount(geometry) }, (_, at) => {
      const point = new Vector3().fromBufferAttribute(positions, at).applyMatrix4(object.matrixWorld);
      return [point.x, point.y, point.z];
    });
  }

  dispose(): void {
    this.painting.close();
    this.controls.dispose();
    this.ghosts.dispose();
    disposeObject(this.scene);
    this.renderer.dispose();
  }

  private paint(): void {
    const nowMs = this.model.nowMs();
    this.updateRobot(nowMs);
    this.ghosts.update(this.robot, this.model, this.options);
    this.updateLayers();
    this.updateFrames();
    this.followRobot();
    this.renderer.render(this.scene, this.camera);
    this.painted += 1;
    window.__talaiaSceneDrawn?.(this.news);
    this.news = [];
  }

  private updateRobot(nowMs: number): void {
    const { model, options } = this;
    if (model.urdf !== this.urdf) {
      this.urdf = model.urdf;
      if (this.robot !== null) {
        this.scene.remove(this.robot.root);
        disposeObject(this.robot.root);
      }
      try {
        const missing = new MissingMeshes(this.onTrouble);
        this.robot = new RobotModel(model.urdf, this.meshes, { onChange: this.schedule, onTrouble: missing.add });
        this.scene.add(this.robot.root);
        this.robot.addFrames(model, model.joints, nowMs);
      } catch (error) {
        this.robot = null;
        this.onTrouble(error instanceof Error ? error.message : String(error));
      }
    }
    const { robot } = this;
    if (robot === null) return;
    const jointsUs = model.joints?.timeUs ?? -1;
    if (jointsUs !== this.jointsUs) {
      this.jointsUs = jointsUs;
      robot.addFrames(model, model.joints, nowMs);
    }
    robot.placeLinks(model);
    const place = model.tree.find(options.fixed, robot.frame, Infinity);
    // A robot that is joined to nothing else stands in the middle when there is nothing else.
    robot.root.visible = options.showRobot && (place !== null || options.fixed === "" || options.fixed === robot.frame);
    if (place !== null) placeObject(robot.root, place);
  }

  private updateLayers(): void {
    const { model, options } = this;
    const { repaint } = this;
    this.repaint = false;
    for (const [topic, { object }] of this.drawn) {
      if (model.layers.has(topic) && !repaint) continue;
      this.scene.remove(object);
      disposeObject(object);
      this.drawn.delete(topic);
    }
    const nowMs = model.nowMs();
    for (const layer of model.layers.values()) {
      const object = this.drawnLayer(layer);
      const place = model.placeOf(layer, options.fixed);
      object.visible = place !== null;
      if (place !== null) placeObject(object, place);
      if (layer.content.shape === "camera") fadeFrustum(object, nowMs);
      if (layer.content.shape === "markers") this.placeMarkers(object, layer.content.markers, nowMs);
    }
  }

  private drawnLayer(layer: SceneLayer): Object3D {
    const { topic, number, content, timeUs } = layer;
    const known = this.drawn.get(topic);
    if (known?.number === number) return known.object;
    this.news.push([topic, timeUs]);
    const paints = { ...this.colours, cloudBy: this.options.cloudBy };
    if (known !== undefined && (redrawPoints(known.object, content, paints) || redrawFrustum(known.object, content))) {
      this.drawn.set(topic, { object: known.object, number });
      return known.object;
    }
    if (known !== undefined) {
      this.scene.remove(known.object);
      disposeObject(known.object);
    }
    const object = drawLayer(content, paints);
    object.frustumCulled = false;
    this.drawn.set(topic, { object, number });
    this.scene.add(object);
    return object;
  }

  /** Each marker has a frame and an end of its own. */
  private placeMarkers(group: Object3D, markers: readonly { readonly marker: Marker; readonly endsMs: number }[], nowMs: number): void {
    for (const object of group.children) {
      const marker = object.userData["marker"] as Marker;
      const place = this.model.tree.find(this.options.fixed, marker.frame, marker.timeUs === 0 ? Infinity : marker.timeUs);
      const endsMs = markers.find((living) => living.marker === marker)?.endsMs ?? Infinity;
      object.visible = place !== null && nowMs < endsMs;
      if (place !== null) placeObject(object, composed(place, marker.pose));
    }
  }

  private updateFrames(): void {
    const { model, options } = this;
    const rows = options.showFrames ? model.tree.rows(model.nowMs()) : [];
    const shown = new Set(rows.map(({ name }) => name));
    for (const [name, axes] of this.frames) {
      if (shown.has(name)) continue;
      this.scene.remove(axes);
      disposeObject(axes);
      this.frames.delete(name);
    }
    for (const name of shown) {
      const axes = this.frames.get(name) ?? new AxesHelper(0.25);
      this.frames.set(name, axes);
      const place = model.tree.find(options.fixed, name, Infinity);
      axes.visible = place !== null;
      if (place !== null) placeObject(axes, place);
      this.scene.add(axes);
    }
  }

  private followRobot(): void {
    const { follow, fixed } = this.options;
    const place = follow === "" ? null : this.model.tree.find(fixed, follow, Infinity);
    if (place === null) {
      this.followed = null;
      return;
    }
    // Camera and what it looks at move along; how one has turned and zoomed stays.
    const before = this.followed ?? [this.controls.target.x, this.controls.target.y, this.controls.target.z];
    const moved = new Vector3(place.at[0] - before[0], place.at[1] - before[1], place.at[2] - before[2]);
    this.followed = place.at;
    if (moved.lengthSq() < 1e-12) return;
    this.camera.position.add(moved);
    this.controls.target.add(moved);
    this.camera.lookAt(this.controls.target);
    this.camera.updateMatrixWorld();
  }
}

/**
 * Three's own way would let what lies behind the canvas shine through: then the browser draws that for each frame, too,
 * and mixes both. What is opaque is drawn alone.
 */
function openGraphics(canvas: HTMLCanvasElement): WebGL2RenderingContext {
  // In software smooth edges take as long as all the rest together.
  const context = canvas.getContext("webgl2", { alpha: false, antialias: !isSoftware(rendererName()), preserveDrawingBuffer: false });
  if (context === null) throw new Error("no WebGL");
  return context;
}

function placeObject(object: Object3D, { at, turn }: Transform): void {
  object.position.set(...at);
  object.quaternion.set(...turn);
}
