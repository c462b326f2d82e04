/** What a drawing of a scene can do, the one in space and the flat one alike. */

import type { CloudColour } from "../../scene/cloud.js";
import type { FloorPose } from "../../scene/pose-command.js";
import type { Vector } from "../../scene/transform.js";

/** Colours as CSS writes them; of the theme. */
export interface SceneColours {
  readonly background: string;
  readonly line: string;
  readonly strong: string;
  readonly text: string;
  readonly accent: string;
  readonly scan: string;
  readonly path: string;
  readonly poses: string;
  readonly floor: string;
  readonly wall: string;
  readonly unknown: string;
  readonly night: boolean;
}

export interface SceneOptions {
  /** The frame that stands still. */
  readonly fixed: string;
  /** The frame that the camera follows; empty: none. */
  readonly follow: string;
  readonly cloudBy: CloudColour;
  readonly showRobot: boolean;
  readonly showFrames: boolean;
}

/** Whether a picture that was drawn by one shows what it would by the other. */
export function sameOptions(a: SceneOptions, b: SceneOptions): boolean {
  return a.fixed === b.fixed && a.follow === b.follow && a.cloudBy === b.cloudBy && a.showRobot === b.showRobot && a.showFrames === b.showFrames;
}

export interface MeasuredLine {
  readonly from: Vector;
  readonly to: Vector;
}

export interface SceneDrawing {
  /** Frames drawn so far: for tests and measuring. */
  readonly painted: number;
  /** Frame of the robot's model; empty before there is one. */
  readonly modelFrame: string;
  setColours(colours: SceneColours): void;
  setOptions(options: SceneOptions): void;
  resize(width: number, height: number, ratio: number): void;
  lookFrom(where: "above" | "aside"): void;
  zoom(factor: number): void;
  setTool(active: boolean): void;
  floorAt(x: number, y: number): { readonly x: number; readonly y: number } | null;
  canvasPlace(place: Vector): { readonly x: number; readonly y: number };
  setPreview(preview: FloorPose | MeasuredLine | null): void;
  schedule(): void;
  pointsOf(topic: string): readonly Vector[];
  dispose(): void;
}
