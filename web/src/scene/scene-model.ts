/**
 * What a scene shows now, without a drawing: the newest of each topic, and where frames stand.
 * Bytes and times in; both drawings, the one in space and the flat one, read it. Pure.
 */

import type { TopicBytes } from "../generated/wire.js";
import { MessageReader } from "./cdr.js";
import { readCloud, type PointCloud } from "./cloud.js";
import { FrameTree } from "./frame-tree.js";
import { readCameraInfo, rectifiedInfo, type CameraInfo } from "./camera-model.js";
import { readMarker, readMarkers, type Marker } from "./markers.js";
import {
  readGrid, readGridUpdate, readJoints, readOdometry, readPath, readPoseArray, readScan, readStampedPose, readString, readTransforms,
  scanPoints, updatedGrid, type MessageHeader, type JointState, type OccupancyGrid,
} from "./messages.js";
import type { SceneKind } from "./scene-topics.js";
import { composed, IDENTITY, type Transform, type Vector } from "./transform.js";

export type LayerContent =
  | { readonly shape: "scan"; readonly positions: Float32Array }
  | { readonly shape: "cloud"; readonly cloud: PointCloud; readonly every: number }
  | { readonly shape: "grid"; readonly grid: OccupancyGrid }
  | { readonly shape: "line"; readonly points: readonly Vector[]; readonly pose: Transform | null }
  | { readonly shape: "poses"; readonly poses: readonly Transform[] }
  | { readonly shape: "markers"; readonly markers: readonly LivingMarker[] }
  | { readonly shape: "camera"; readonly info: CameraInfo; readonly picture: ScenePicture | null };

/** The newest picture of a camera. */
export interface ScenePicture {
  readonly image: ImageBitmap;
  /** When it was taken (µs). */
  readonly timeUs: number;
  /** By the model's clock. */
  readonly heardMs: number;
  readonly rectified: boolean;
}

export interface LivingMarker {
  readonly marker: Marker;
  /** By the model's clock; Infinity: it stays. */
  readonly endsMs: number;
}

/** One topic's newest, in its frame and of its time. */
export interface SceneLayer extends MessageHeader {
  readonly topic: string;
  readonly content: LayerContent;
  readonly heardMs: number;
  /** Counts the messages: what is drawn already need not be drawn again. */
  readonly number: number;
}

/** Of an odometry's trail. */
const MOST_TRAIL = 5000;
const TRAIL_STEP = 0.02;

export class SceneModel {
  readonly tree = new FrameTree();
  readonly layers = new Map<string, SceneLayer>();
  /** The robot's form as URDF; empty before it came. */
  urdf = "";
  joints: JointState | null = null;
  private count = 0;
  private readonly trails = new Map<string, Vector[]>();
  private readonly markers = new Map<string, Map<string, LivingMarker>>();
  private readonly calibrations = new Map<string, CameraInfo>();
  private readonly pictures = new Map<string, ScenePicture>();

  /** @param nowMs what time it is for the scene (ms): that of now, or that of the moment that it shows */
  constructor(readonly nowMs: () => number = () => performance.now()) {}

  /**
   * @param nowMs when it was heard, by the model's clock
   * @throws MessageError when the bytes are no such message
   */
  applyMessage(topic: string, { kind }: SceneKind, message: TopicBytes, nowMs: number): void {
    const reader = new MessageReader(message.data, message.encoding);
    const show = (header: MessageHeader, content: LayerContent): void => {
      this.layers.set(topic, { topic, timeUs: header.timeUs, frame: header.frame, content, heardMs: nowMs, number: ++this.count });
    };
    switch (kind) {
      case "transforms":
        for (const { frame, child, timeUs, transform } of readTransforms(reader)) {
          this.tree.add({ parent: frame, child, timeUs, transform, source: "tf", fixed: topic.endsWith("_static") }, nowMs);
        }
        return;
      case "joints":
        this.joints = readJoints(reader);
        return;
      case "robot":
        this.urdf = readString(reader);
        return;
      case "scan": {
        const scan = readScan(reader);
        show(scan, { shape: "scan", positions: scanPoints(scan) });
        return;
      }
      case "cloud": {
        const cloud = readCloud(reader);
        show(cloud, { shape: "cloud", cloud, every: message.every });
        return;
      }
      case "grid": {
        const grid = readGrid(reader);
        show(grid, { shape: "grid", grid });
        return;
      }
      case "grid update":
        this.updateGrid(topic.replace(/_updates$/, ""), reader, nowMs);
        return;
      case "path": {
        const path = readPath(reader);
        show(path, { shape: "line", points: path.poses.map(({ at }) => at), pose: null });
        return;
      }
      case "odometry": {
        const odometry = readOdometry(reader);
        this.tree.add({ parent: odometry.frame, child: odometry.child, timeUs: odometry.timeUs, transform: odometry.pose, source: "odometry", fixed: false }, nowMs);
        show(odometry, { shape: "line", points: this.trailOf(topic, odometry.pose.at), pose: odometry.pose });
        return;
      }
      case "poses": {
        const poses = readPoseArray(reader);
        show(poses, { shape: "poses", poses: poses.poses });
        return;
      }
      case "pose": {
        const pose = readStampedPose(reader);
        show(pose, { shape: "poses", poses: pose.poses });
        return;
      }
      case "camera":
        this.calibrations.set(topic, readCameraInfo(reader));
        this.showCamera(topic, nowMs);
        return;
      case "marker":
      case "markers": {
        const markers = kind === "marker" ? [readMarker(reader)] : readMarkers(reader);
        show({ timeUs: 0, frame: "" }, { shape: "markers", markers: this.changedMarkers(topic, markers, nowMs) });
        return;
      }
    }
  }

  /** Shows a camera's newest picture, as the calibration of `topic` places it; null: there is none that is true any more. */
  setPicture(topic: string, picture: ScenePicture | null): void {
    const before = this.pictures.get(topic);
    if (before !== undefined && before.image !== picture?.image) before.image.close();
    if (picture === null) this.pictures.delete(topic);
    else this.pictures.set(topic, picture);
    this.showCamera(topic, picture?.heardMs ?? this.nowMs());
  }

  /** Forgets what a topic said: it is not shown any more. `keepsPicture`: its picture did not come with it. */
  forget(topic: string, keepsPicture = false): void {
    this.calibrations.delete(topic);
    if (!keepsPicture) this.setPicture(topic, null);
    this.layers.delete(topic);
    this.trails.delete(topic);
    this.markers.delete(topic);
  }

  /** Forgets all but the robot's form, and the pictures of which whoever shows them knows the moment: another one is shown. */
  reset(keepsPicture: (topic: string) => boolean = () => false): void {
    for (const topic of [...this.pictures.keys(), ...this.calibrations.keys()]) this.forget(topic, keepsPicture(topic));
    this.tree.clear();
    this.layers.clear();
    this.trails.clear();
    this.markers.clear();
    this.joints = null;
  }

  /** Where a layer stands in the frame that stands still; null: nothing joins them. */
  placeOf(layer: MessageHeader, fixed: string): Transform | null {
    return layer.frame === "" ? IDENTITY : this.tree.find(fixed, layer.frame, layer.timeUs);
  }

  private showCamera(topic: string, heardMs: number): void {
    const known = this.calibrations.get(topic);
    if (known === undefined) return;
    const picture = this.pictures.get(topic) ?? null;
    const info = picture?.rectified === true ? rectifiedInfo(known) : known;
    // It stands where the camera was when the picture was taken.
    const timeUs = picture?.timeUs ?? info.timeUs;
    this.layers.set(topic, { topic, timeUs, frame: info.frame, content: { shape: "camera", info, picture }, heardMs: picture?.heardMs ?? heardMs, number: ++this.count });
  }

  private updateGrid(topic: string, reader: MessageReader, nowMs: number): void {
    const layer = this.layers.get(topic);
    if (layer?.content.shape !== "grid") return;
    const grid = updatedGrid(layer.content.grid, readGridUpdate(reader));
    this.layers.set(topic, { ...layer, content: { shape: "grid", grid }, heardMs: nowMs, number: ++this.count });
  }

  private trailOf(topic: string, at: Vector): readonly Vector[] {
    const trail = this.trails.get(topic) ?? [];
    const last = trail.at(-1);
    if (last === undefined || Math.hypot(last[0] - at[0], last[1] - at[1], last[2] - at[2]) >= TRAIL_STEP) trail.push(at);
    if (trail.length > MOST_TRAIL) trail.splice(0, trail.length - MOST_TRAIL);
    this.trails.set(topic, trail);
    return trail;
  }

  private changedMarkers(topic: string, news: readonly Marker[], nowMs: number): readonly LivingMarker[] {
    const known = this.markers.get(topic) ?? new Map<string, LivingMarker>();
    this.markers.set(topic, known);
    for (const marker of news) {
      if (marker.action === "remove all") known.clear();
      else if (marker.action === "remove") known.delete(marker.key);
      else known.set(marker.key, { marker, endsMs: marker.lifetimeMs > 0 ? nowMs + marker.lifetimeMs : Infinity });
    }
    return [...known.values()];
  }
}

/** Whether a picture of it becomes another one as time passes, though nothing comes: markers that end, pictures that fade. */
export function changesByItself({ layers }: Pick<SceneModel, "layers">): boolean {
  for (const { content } of layers.values()) {
    if (content.shape === "camera" && content.picture !== null) return true;
    if (content.shape === "markers" && content.markers.some(({ endsMs }) => endsMs !== Infinity)) return true;
  }
  return false;
}

/** Points of a layer where they are in the frame that stands still. */
export function placedPoints(positions: Float32Array, place: Transform): Float32Array {
  const found = new Float32Array(positions.length);
  for (let i = 0; i + 2 < positions.length; i += 3) {
    found.set(composed(place, { at: [positions[i] ?? 0, positions[i + 1] ?? 0, positions[i + 2] ?? 0], turn: [0, 0, 0, 1] }).at, i);
  }
  return found;
}
