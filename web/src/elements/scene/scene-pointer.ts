/** The pointer on a scene's floor while a tool is used: two places that are measured, or a place with a heading. Pure but for its events. */

import type { FloorPose } from "../../scene/pose-command.js";
import type { MeasuredLine, SceneDrawing } from "./drawing.js";

/** Shorter drags (m) leave the heading as it is. */
const LEAST_DRAG = 0.05;

export type ScenePreview = MeasuredLine | FloorPose | null;

interface FloorPlace {
  readonly x: number;
  readonly y: number;
}

export class ScenePointer {
  private from: FloorPlace | null = null;

  constructor(
    private readonly tool: "measure" | "pose",
    private readonly frame: string,
    private readonly onPreview: (preview: ScenePreview) => void,
    private readonly onPose: (pose: FloorPose) => void,
  ) {}

  handle(event: PointerEvent, drawing: SceneDrawing): void {
    const place = drawing.floorAt(event.offsetX, event.offsetY);
    if (place === null) return;
    if (event.type === "pointerdown") this.from = place;
    if (this.from === null) return;
    const { from } = this;
    const line = { from: [from.x, from.y, 0.02] as const, to: [place.x, place.y, 0.02] as const };
    const far = Math.hypot(place.x - from.x, place.y - from.y) >= LEAST_DRAG;
    const pose = { frame: this.frame, x: from.x, y: from.y, yaw: far ? Math.atan2(place.y - from.y, place.x - from.x) : 0 };
    this.onPreview(this.tool === "measure" ? line : pose);
    if (event.type !== "pointerup") return;
    this.from = null;
    if (this.tool === "pose") this.onPose(pose);
  }
}

/** How long a measured line is (m). */
export function lengthOf({ from, to }: MeasuredLine): number {
  return Math.hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
}
