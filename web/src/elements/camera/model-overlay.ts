/** What models tell of a camera's picture, drawn over it: areas with their names, skeletons, depth. */

import { css, html, LitElement, nothing, svg, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, queryAll } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ElementSizeController } from "../../controllers/element-size.js";
import { confidenceText } from "../../format/object-names.js";
import type { PictureModelShape } from "../../generated/api.js";
import type { DetectedPose, OverlayLayer } from "../../generated/wire.js";
import { styled } from "../base/style-directive.js";
import { cellRuns, colourNumber, DEPTH_STEPS, namedClasses, type PictureOverlay } from "./overlay-layer.js";
import { placeOf, type PixelSize } from "./picture-fit.js";
import { WHOLE, type Zoom } from "./zoom.js";

/** Half of what a name takes (px), and of each letter. */
const NAME_PX = 8;
const LETTER_PX = 4;
const ALL = { left: 0, top: 0, right: 1, bottom: 1 };

/** Lies over the picture and takes nothing from it: presses and screen readers go past. */
@customElement("t-model-overlay")
export class ModelOverlayView extends LitElement {
  static override styles = css`
    :host {
      display: block;
      position: absolute;
      inset: 0;
      overflow: hidden;
      pointer-events: none;
    }
    canvas {
      position: absolute;
      opacity: 0.5;
      image-rendering: pixelated;
    }
    .depth {
      opacity: 0.75;
    }
    .earlier {
      opacity: 0.2;
    }
    svg {
      position: absolute;
      inset: 0;
      inline-size: 100%;
      block-size: 100%;
    }
    /* A line of its colour on a black one is seen on any picture. */
    .under {
      stroke: #000;
      stroke-width: 5;
      stroke-linecap: round;
    }
    .bone {
      stroke: var(--t-box-person);
      stroke-width: 2.5;
      stroke-linecap: round;
    }
    circle {
      fill: var(--t-box-person);
      stroke: #000;
    }
    .earlier .bone {
      stroke-dasharray: 5 5;
    }
    .name {
      position: absolute;
      translate: -50% -50%;
      padding: 0 0.4em;
      border-radius: 3px;
      background: #000;
      color: var(--t-box-thing);
      font-size: var(--t-size-s);
      font-weight: var(--t-weight-strong);
      line-height: 1.4;
      white-space: nowrap;
      font-variant-numeric: tabular-nums;
    }
  `;

  @property({ attribute: false }) overlays: readonly PictureOverlay[] = [];
  /** Of the picture (px). */
  @property({ attribute: false }) picture: PixelSize = { width: 4, height: 3 };
  @property({ attribute: false }) zoom: Zoom = WHOLE;

  @queryAll("canvas") private readonly maps!: NodeListOf<HTMLCanvasElement>;
  private readonly view = new ElementSizeController(this);

  override render(): TemplateResult | typeof nothing {
    if (this.view.size.width === 0) return nothing;
    // Names lie over all areas.
    return html`<div aria-hidden="true">
      ${map(this.overlays, (overlay) => this.renderMap(overlay))} ${map(this.overlays, (overlay) => this.renderMarks(overlay))}
    </div>`;
  }

  override updated(changed: PropertyValues<this>): void {
    for (const canvas of this.maps) {
      // Another place for the same cells paints nothing anew.
      if (!changed.has("overlays") && canvas.dataset.drawn !== undefined) continue;
      const overlay = this.overlays.find(({ model }) => model.id === canvas.dataset.model);
      if (overlay !== undefined) this.paintMap(canvas, overlay.model, overlay.layer);
    }
  }

  private renderMap({ model, layer, earlier }: PictureOverlay): unknown {
    if (layer.rows === 0) return nothing;
    const { x, y, width, height } = placeOf(ALL, this.view.size, this.picture, this.zoom);
    const where = { left: `${x.toFixed(1)}px`, top: `${y.toFixed(1)}px`, width: `${width.toFixed(1)}px`, height: `${height.toFixed(1)}px` };
    return html`<canvas class="${model.kind} ${earlier ? "earlier" : ""}" data-model=${model.id} width=${layer.columns} height=${layer.rows} ${styled(where)}></canvas>`;
  }

  private renderMarks({ model, layer, earlier }: PictureOverlay): unknown {
    if (model.kind === "keypoints") return this.renderPoses(model, layer.poses, earlier ? "earlier" : "");
    if (model.kind !== "segmentation" || earlier) return nothing;
    return map(namedClasses(model, layer), ({ name, x, y }) => this.renderName(name, x, y));
  }

  private renderName(name: string, x: number, y: number): TemplateResult {
    const place = placeOf({ left: x, top: y, right: x, bottom: y }, this.view.size, this.picture, this.zoom);
    // About half of the name has to fit between the middle and the edge.
    const half = NAME_PX + name.length * LETTER_PX;
    const left = Math.min(Math.max(place.x, half), this.view.size.width - half);
    return html`<span class="name" data-name=${name} ${styled({ left: `${left.toFixed(1)}px`, top: `${place.y.toFixed(1)}px` })}>${name}</span>`;
  }

  private renderPoses(model: PictureModelShape, poses: readonly DetectedPose[], faded: string): TemplateResult {
    return html`<svg class=${faded}>${map(poses, (pose) => this.renderPose(model, pose))}</svg>
      ${map(poses, (pose) => this.renderName(`${model.classes[0] ?? ""} ${confidenceText(pose.score)}`, (pose.left + pose.right) / 2, pose.top))}`;
  }

  private renderPose(model: PictureModelShape, pose: DetectedPose): TemplateResult {
    const spots = pose.points.map(([x, y, sure]) =>
      sure < model.confidence ? null : placeOf({ left: x, top: y, right: x, bottom: y }, this.view.size, this.picture, this.zoom),
    );
    const bones = model.bones.flatMap(({ start, end }) => {
      const [from, to] = [spots[start] ?? null, spots[end] ?? null];
      return from === null || to === null ? [] : [{ from, to }];
    });
    return svg`${map(["under", "bone"], (kind) =>
      map(bones, ({ from, to }) => svg`<line class=${kind} x1=${from.x} y1=${from.y} x2=${to.x} y2=${to.y}></line>`),
    )}${map(spots, (spot) => (spot === null ? nothing : svg`<circle cx=${spot.x} cy=${spot.y} r="3.5"></circle>`))}`;
  }

  /** A class in its colour; depth in one colour, the more of it the nearer. */
  private paintMap(canvas: HTMLCanvasElement, model: PictureModelShape, layer: OverlayLayer): void {
    const context = canvas.getContext("2d");
    if (context === null) return;
    const style = getComputedStyle(this);
    context.clearRect(0, 0, canvas.width, canvas.height);
    for (const { row, column, length, value } of cellRuns(layer)) {
      if (model.kind === "depth") {
        if (value > DEPTH_STEPS) continue;
        context.globalAlpha = value / DEPTH_STEPS;
        context.fillStyle = style.getPropertyValue("--t-box-person");
      } else {
        const colour = colourNumber(model, value);
        if (colour === 0) continue;
        context.fillStyle = style.getPropertyValue(`--t-series-${String(colour)}`);
      }
      context.fillRect(column, row, length, 1);
    }
    canvas.dataset.drawn = "";
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-model-overlay": ModelOverlayView;
  }
}
