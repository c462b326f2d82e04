/** The scene from above, on a plain canvas: where a browser has no WebGL. */

import { FrameSchedule } from "../base/frame-schedule.js";
import { isCalibrated, picturePlane } from "../../scene/camera-model.js";
import { cloudColours } from "../../scene/colours.js";
import type { OccupancyGrid } from "../../scene/messages.js";
import type { FloorPose } from "../../scene/pose-command.js";
import { placedPoints, type SceneLayer, type SceneModel } from "../../scene/scene-model.js";
import { applied, composed, yawOf, type Transform, type Vector } from "../../scene/transform.js";
import { sameOptions, type MeasuredLine, type SceneColours, type SceneDrawing, type SceneOptions } from "./drawing.js";
import { gridPixels } from "./grid-pixels.js";

/** px of a metre: at first, at the least and at the most. */
const SCALE = { start: 60, least: 2, most: 1000 } as const;
const ROBOT_PX = 9;
const ARROW_M = 0.3;
/** How far a camera's sight is drawn: its picture lies on edge from above. */
const SIGHT_M = 0.6;

export class FlatView implements SceneDrawing {
  painted = 0;
  readonly modelFrame = "";
  private readonly pen: CanvasRenderingContext2D;
  private width = 1;
  private height = 1;
  private ratio = 1;
  private scale: number = SCALE.start;
  /** What of the floor is in the middle (m). */
  private middle = { x: 0, y: 0 };
  private options: SceneOptions = { fixed: "", follow: "", cloudBy: "height", showRobot: true, showFrames: false };
  private preview: FloorPose | MeasuredLine | null = null;
  private tool = false;
  private dragged: { readonly x: number; readonly y: number } | null = null;
  private readonly painting = new FrameSchedule(() => {
    this.paint();
  });

  /** @throws Error when there is no canvas to draw on */
  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly model: SceneModel,
    private colours: SceneColours,
  ) {
    const pen = canvas.getContext("2d");
    if (pen === null) throw new Error("this browser has no canvas to draw on");
    this.pen = pen;
    canvas.addEventListener("pointerdown", this.onDown);
    canvas.addEventListener("pointermove", this.onMove);
    canvas.addEventListener("pointerup", this.onUp);
    canvas.addEventListener("wheel", this.onWheel, { passive: false });
  }

  setColours(colours: SceneColours): void {
    this.colours = colours;
    this.schedule();
  }

  setOptions(options: SceneOptions): void {
    const same = sameOptions(options, this.options);
    this.options = options;
    if (!same) this.schedule();
  }

  resize(width: number, height: number, ratio: number): void {
    [this.width, this.height, this.ratio] = [Math.max(1, width), Math.max(1, height), ratio];
    this.canvas.width = Math.round(this.width * ratio);
    this.canvas.height = Math.round(this.height * ratio);
    this.schedule();
  }

  lookFrom(): void {
    this.middle = { x: 0, y: 0 };
    this.scale = SCALE.start;
    this.schedule();
  }

  zoom(factor: number): void {
    this.scale = Math.min(SCALE.most, Math.max(SCALE.least, this.scale / factor));
    this.schedule();
  }

  setTool(active: boolean): void {
    this.tool = active;
  }

  floorAt(x: number, y: number): { readonly x: number; readonly y: number } {
    return { x: this.middle.x + (x - this.width / 2) / this.scale, y: this.middle.y - (y - this.height / 2) / this.scale };
  }

  canvasPlace([x, y]: Vector): { readonly x: number; readonly y: number } {
    return { x: this.width / 2 + (x - this.middle.x) * this.scale, y: this.height / 2 - (y - this.middle.y) * this.scale };
  }

  setPreview(preview: FloorPose | MeasuredLine | null): void {
    this.preview = preview;
    this.schedule();
  }

  readonly schedule = (): void => {
    this.painting.schedule();
  };

  pointsOf(topic: string): readonly Vector[] {
    const layer = this.model.layers.get(topic);
    const place = layer === undefined ? null : this.model.placeOf(layer, this.options.fixed);
    if (layer?.content.shape !== "scan" || place === null) return [];
    const placed = placedPoints(layer.content.positions, place);
    return Array.from({ length: placed.length / 3 }, (_, at) => [placed[3 * at] ?? 0, placed[3 * at + 1] ?? 0, placed[3 * at + 2] ?? 0]);
  }

  dispose(): void {
    this.painting.close();
    this.canvas.removeEventListener("pointerdown", this.onDown);
    this.canvas.removeEventListener("pointermove", this.onMove);
    this.canvas.removeEventListener("pointerup", this.onUp);
    this.canvas.removeEventListener("wheel", this.onWheel);
  }

  private paint(): void {
    const { pen, colours, options, model } = this;
    const follow = options.follow === "" ? null : model.tree.find(options.fixed, options.follow, Infinity);
    if (follow !== null) this.middle = { x: follow.at[0], y: follow.at[1] };
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    pen.fillStyle = colours.background;
    pen.fillRect(0, 0, this.width, this.height);
    const layers = [...model.layers.values()];
    // The map below all else.
    for (const layer of layers) if (layer.content.shape === "grid") this.paintLayer(layer);
    this.paintRaster();
    for (const layer of layers) if (layer.content.shape !== "grid") this.paintLayer(layer);
    if (follow !== null && options.showRobot) this.paintRobot(follow);
    this.paintPreview();
    this.painted += 1;
  }

  private paintRaster(): void {
    const { pen } = this;
    const low = this.floorAt(0, this.height);
    const high = this.floorAt(this.width, 0);
    if (high.x - low.x > 200) return;
    pen.strokeStyle = this.colours.line;
    pen.lineWidth = 1;
    pen.beginPath();
    for (let x = Math.ceil(low.x); x <= high.x; x++) this.stroke([x, low.y, 0], [x, high.y, 0]);
    for (let y = Math.ceil(low.y); y <= high.y; y++) this.stroke([low.x, y, 0], [high.x, y, 0]);
    pen.stroke();
  }

  private stroke(from: Vector, to: Vector): void {
    const [a, b] = [this.canvasPlace(from), this.canvasPlace(to)];
    this.pen.moveTo(a.x, a.y);
    this.pen.lineTo(b.x, b.y);
  }

  private paintLayer(layer: SceneLayer): void {
    const { pen, colours } = this;
    const place = this.model.placeOf(layer, this.options.fixed);
    if (place === null) return;
    switch (layer.content.shape) {
      case "scan":
        pen.fillStyle = colours.scan;
        this.paintPoints(placedPoints(layer.content.positions, place), 3);
        return;
      case "cloud": {
        const shades = cloudColours(layer.content.cloud, this.options.cloudBy, colours.night);
        this.paintPoints(placedPoints(layer.content.cloud.positions, place), 2, shades);
        return;
      }
      case "grid":
        this.paintGrid(layer.content.grid, place);
        return;
      case "line":
        pen.strokeStyle = colours.path;
        pen.lineWidth = 2;
        pen.beginPath();
        layer.content.points.forEach((point, at, all) => {
          const before = all[at - 1];
          if (before !== undefined) this.stroke(applied(place, before), applied(place, point));
        });
        pen.stroke();
        return;
      case "poses":
        pen.strokeStyle = colours.poses;
        pen.lineWidth = 2;
        pen.beginPath();
        for (const pose of layer.content.poses) {
          const placed = composed(place, pose);
          this.stroke(placed.at, applied(placed, [ARROW_M, 0, 0]));
        }
        pen.stroke();
        return;
      case "camera": {
        if (!isCalibrated(layer.content.info)) return;
        const [left, right] = picturePlane(layer.content.info, SIGHT_M).corners;
        pen.strokeStyle = colours.accent;
        pen.lineWidth = 2;
        pen.beginPath();
        for (const corner of [left, right]) this.stroke(place.at, applied(place, corner));
        pen.stroke();
        return;
      }
      case "markers":
        // Of no use from above without their forms.
        return;
    }
  }

  private paintPoints(points: Float32Array, size: number, shades: Uint8Array | null = null): void {
    for (let i = 0; i + 2 < points.length; i += 3) {
      const { x, y } = this.canvasPlace([points[i] ?? 0, points[i + 1] ?? 0, 0]);
      if (shades !== null) this.pen.fillStyle = `rgb(${shades.subarray((i / 3) * 4, (i / 3) * 4 + 3).join(" ")})`;
      this.pen.fillRect(x - size / 2, y - size / 2, size, size);
    }
  }

  private paintGrid(grid: OccupancyGrid, place: Transform): void {
    const { pen } = this;
    const { width, height, resolution } = grid;
    if (width * height === 0 || grid.cells.length < width * height) return;
    const picture = new OffscreenCanvas(width, height);
    picture.getContext("2d")?.putImageData(new ImageData(new Uint8ClampedArray(gridPixels(grid, this.colours).buffer), width, height), 0, 0);
    const origin = composed(place, grid.origin);
    const { x, y } = this.canvasPlace(origin.at);
    pen.save();
    pen.translate(x, y);
    // A canvas counts down, a map up.
    pen.rotate(-yawOf(origin.turn));
    pen.scale(resolution * this.scale, -resolution * this.scale);
    pen.imageSmoothingEnabled = false;
    pen.drawImage(picture, 0, 0);
    pen.restore();
  }

  private paintRobot({ at, turn }: Transform): void {
    const { pen } = this;
    const { x, y } = this.canvasPlace(at);
    pen.save();
    pen.translate(x, y);
    pen.rotate(-yawOf(turn));
    pen.fillStyle = this.colours.accent;
    pen.beginPath();
    pen.moveTo(1.6 * ROBOT_PX, 0);
    pen.lineTo(-ROBOT_PX, ROBOT_PX);
    pen.lineTo(-ROBOT_PX, -ROBOT_PX);
    pen.fill();
    pen.restore();
  }

  private paintPreview(): void {
    const { pen, preview } = this;
    if (preview === null) return;
    pen.strokeStyle = this.colours.accent;
    pen.lineWidth = 3;
    pen.beginPath();
    if ("yaw" in preview) this.stroke([preview.x, preview.y, 0], [preview.x + 0.5 * Math.cos(preview.yaw), preview.y + 0.5 * Math.sin(preview.yaw), 0]);
    else this.stroke(preview.from, preview.to);
    pen.stroke();
  }

  private readonly onDown = (event: PointerEvent): void => {
    if (!this.tool) this.dragged = { x: event.offsetX, y: event.offsetY };
  };

  private readonly onMove = (event: PointerEvent): void => {
    if (this.dragged === null) return;
    this.middle = { x: this.middle.x - (event.offsetX - this.dragged.x) / this.scale, y: this.middle.y + (event.offsetY - this.dragged.y) / this.scale };
    this.dragged = { x: event.offsetX, y: event.offsetY };
    this.schedule();
  };

  private readonly onUp = (): void => {
    this.dragged = null;
  };

  private readonly onWheel = (event: WheelEvent): void => {
    event.preventDefault();
    this.zoom(event.deltaY > 0 ? 1.15 : 1 / 1.15);
  };
}
