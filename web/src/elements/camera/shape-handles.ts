/** Zones and lines over a camera's picture, with handles to drag their points by pointer and keyboard. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, svg, type TemplateResult } from "lit";
import { customElement, property, queryAll } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ElementSizeController } from "../../controllers/element-size.js";
import { styled } from "../base/style-directive.js";
import { arrowHead, nameSpot, pointsText, sideSpots, viewPoints, type PicturePoint, type ViewPoint } from "./mark-shapes.js";
import { partAt, type PixelSize } from "./picture-fit.js";
import { WHOLE, type Zoom } from "./zoom.js";

export interface HandledShape {
  readonly kind: "zone" | "line";
  readonly name: string;
  readonly points: readonly PicturePoint[];
}

/** Where a point may be added: after which one, and where that is. */
export interface ShapeGap {
  readonly after: number;
  readonly at: PicturePoint;
}

/** What a person did at a handle; `along` goes on with the drag before. */
export type ShapeEdit =
  | { readonly what: "choose"; readonly shape: number }
  | { readonly what: "move point"; readonly shape: number; readonly point: number; readonly to: PicturePoint; readonly along: boolean }
  | { readonly what: "move"; readonly shape: number; readonly dx: number; readonly dy: number; readonly along: boolean }
  | { readonly what: "add point"; readonly shape: number; readonly after: number }
  | { readonly what: "delete point"; readonly shape: number; readonly point: number };

const ARROW_PX = 12;
/** From a line's middle, its sides are named so far off (px). */
const SIDE_PX = 26;
/** The name of a chosen line is out of the way of what can be pressed on it (px). */
const NAME_PX = 34;
/** One press of an arrow key moves so far (parts of the picture), and with Shift. */
const STEP = 0.005;
const LONG_STEP = 0.05;
const WAYS: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

/** What is dragged: a point of the chosen shape, or all of it (-1), from where it was held last. */
interface Drag {
  readonly pointer: number;
  readonly point: number;
  from: PicturePoint;
  along: boolean;
}

/** @fires t-shape-edit detail is what was done, a `ShapeEdit` */
@customElement("t-shape-handles")
export class ShapeHandles extends LitElement {
  /* White on black is seen on any picture; what is chosen has the accent as well as its handles. */
  static override styles = css`
    :host {
      display: block;
      position: absolute;
      inset: 0;
      overflow: hidden;
      pointer-events: none;
    }
    svg {
      position: absolute;
      inset: 0;
      inline-size: 100%;
      block-size: 100%;
    }
    .under,
    .over {
      fill: none;
      stroke-linejoin: round;
    }
    .under {
      stroke: #000;
      stroke-width: 4;
      stroke-opacity: 0.6;
    }
    .over {
      stroke: var(--t-box-thing);
      stroke-width: 1.5;
    }
    .zone.over {
      stroke-dasharray: 6 4;
    }
    .chosen.over {
      stroke-width: 3;
      stroke-dasharray: none;
    }
    /* What is pressed: as wide as a finger, and all of a zone. */
    .hit {
      fill: none;
      stroke: transparent;
      stroke-width: 28;
      pointer-events: stroke;
      cursor: pointer;
      touch-action: none;
    }
    .hit.zone {
      fill: rgb(255 255 255 / 8%);
      pointer-events: all;
    }
    .hit.chosen {
      cursor: move;
    }
    .hit.zone.chosen {
      fill: rgb(255 255 255 / 18%);
    }
    button {
      position: absolute;
      display: grid;
      place-items: center;
      translate: -50% -50%;
      padding: 0;
      border: 0;
      background: none;
      pointer-events: auto;
      touch-action: none;
    }
    .point {
      inline-size: var(--t-touch);
      block-size: var(--t-touch);
      cursor: grab;
    }
    .point::before {
      content: "";
      inline-size: 16px;
      block-size: 16px;
      border: 2px solid #000;
      border-radius: 50%;
      background: #fff;
    }
    .gap {
      inline-size: 28px;
      block-size: 28px;
      cursor: copy;
    }
    .gap::before {
      content: "+";
      inline-size: 18px;
      block-size: 18px;
      border: 1px solid #fff;
      border-radius: 50%;
      background: #000;
      color: #fff;
      font-size: 14px;
      line-height: 17px;
    }
    .name {
      max-inline-size: 12rem;
      padding: 0.2em 0.6em;
      border: 1px solid transparent;
      border-radius: 3px;
      background: rgb(0 0 0 / 78%);
      color: #fff;
      font: inherit;
      font-size: var(--t-size-s);
      cursor: pointer;
    }
    .name.chosen {
      border-color: #fff;
      cursor: move;
    }
    .side {
      position: absolute;
      translate: -50% -50%;
      padding: 0 0.4em;
      border-radius: 3px;
      background: rgb(0 0 0 / 78%);
      color: #fff;
      font-size: var(--t-size-s);
    }
    button:focus-visible {
      outline: 3px solid #fff;
      outline-offset: -3px;
      box-shadow: 0 0 0 2px #000;
      border-radius: var(--t-radius-s);
    }
  `;

  @property({ attribute: false }) shapes: readonly HandledShape[] = [];
  /** The one that has handles; -1 for none. */
  @property({ type: Number }) chosen = -1;
  /** Where points may be added to it. */
  @property({ attribute: false }) gaps: readonly ShapeGap[] = [];
  /** Of the picture (px). */
  @property({ attribute: false }) picture: PixelSize = { width: 4, height: 3 };
  @property({ attribute: false }) zoom: Zoom = WHOLE;

  @queryAll(".point") private readonly points!: NodeListOf<HTMLElement>;
  private readonly view = new ElementSizeController(this);
  private drag: Drag | null = null;

  /** Puts the keyboard on a point of the chosen shape. */
  focusPoint(index: number): void {
    void this.updateComplete.then(() => {
      [...this.points].find(({ dataset }) => dataset["point"] === String(index))?.focus();
    });
  }

  override render(): TemplateResult | typeof nothing {
    if (this.view.size.width === 0) return nothing;
    const placed = this.shapes.map(({ points }) => this.viewed(points));
    const shape = this.shapes[this.chosen];
    return html`<svg aria-hidden="true">
        ${map(placed, (points, index) => this.renderOutline(points, index))}
      </svg>
      ${map(placed, (points, index) => this.renderName(points, index))}
      ${shape === undefined ? nothing : this.renderHandles(shape, placed[this.chosen] ?? [])}`;
  }

  private renderOutline(points: readonly ViewPoint[], index: number): unknown {
    const kind = this.shapes[index]?.kind ?? "zone";
    const text = pointsText(points);
    const is = index === this.chosen ? `${kind} chosen` : kind;
    const hold = (event: PointerEvent): void => {
      this.beginDrag(event, index, -1);
    };
    // Each listens by itself: what is drawn later lies above, as on the picture.
    const held = svg`<polyline class="hit ${is}" points=${kind === "zone" ? pointsText([...points, ...points.slice(0, 1)]) : text}
      @pointerdown=${hold} @pointermove=${this.onDrag} @pointerup=${this.onDrop} @pointercancel=${this.onDrop}></polyline>`;
    if (kind === "zone") return svg`<polygon class="under" points=${text}></polygon><polygon class="over ${is}" points=${text}></polygon>${held}`;
    // Before the end, where a handle would lie on it.
    const head = pointsText(arrowHead([...points.slice(0, -1), nearEnd(points)], ARROW_PX));
    return svg`<polyline class="under" points=${text}></polyline><polyline class="under" points=${head}></polyline>
      <polyline class="over ${is}" points=${text}></polyline><polyline class="over" points=${head}></polyline>${held}`;
  }

  private renderName(points: readonly ViewPoint[], index: number): TemplateResult {
    const shape = this.shapes[index];
    const kind = shape?.kind ?? "zone";
    const name = shape?.name === undefined || shape.name === "" ? (kind === "zone" ? msg("unnamed zone") : msg("unnamed line")) : shape.name;
    const chosen = index === this.chosen;
    const hold = (event: PointerEvent): void => {
      this.beginDrag(event, index, -1);
    };
    const press = (event: KeyboardEvent): void => {
      this.onShapeKey(event, index);
    };
    const choose = (): void => {
      this.report({ what: "choose", shape: index });
    };
    return html`<button
      type="button"
      class="name ${chosen ? "chosen" : ""}"
      aria-pressed=${chosen ? "true" : "false"}
      aria-label=${chosen ? msg(str`${name}, chosen; arrow keys move all of it`) : msg(str`Choose ${name}`)}
      ${styled(placeOf(chosen && kind === "line" ? sideSpots(points, NAME_PX, nameSpot(kind, points)).right : nameSpot(kind, points)))}
      @click=${choose}
      @keydown=${press}
      @pointerdown=${hold}
      @pointermove=${this.onDrag}
      @pointerup=${this.onDrop}
      @pointercancel=${this.onDrop}
    >${name}</button>`;
  }

  private renderHandles(shape: HandledShape, points: readonly ViewPoint[]): TemplateResult {
    // Near the arrow: in the middle a point may be added, and the name stands beside that.
    const sides = shape.kind === "line" ? sideSpots(points, SIDE_PX, nearEnd(points)) : null;
    return html`${sides === null
        ? nothing
        : html`<span class="side" aria-hidden="true" ${styled(placeOf(sides.left))}>${msg("left")}</span>
            <span class="side" aria-hidden="true" ${styled(placeOf(sides.right))}>${msg("right")}</span>`}
      ${map(this.gaps, ({ after, at }) => {
        const [spot = { x: 0, y: 0 }] = this.viewed([at]);
        const add = (): void => {
          this.report({ what: "add point", shape: this.chosen, after });
          this.focusPoint(after + 1);
        };
        return html`<button type="button" class="gap" aria-label=${msg(str`Add a point after point ${String(after + 1)}`)} title=${msg("Add a point")} ${styled(placeOf(spot))} @click=${add}></button>`;
      })}
      ${map(points, (spot, index) => this.renderPoint(shape, spot, index))}`;
  }

  private renderPoint(shape: HandledShape, spot: ViewPoint, index: number): TemplateResult {
    const [x, y] = shape.points[index] ?? [0, 0];
    const hold = (event: PointerEvent): void => {
      this.beginDrag(event, this.chosen, index);
    };
    const press = (event: KeyboardEvent): void => {
      this.onPointKey(event, index);
    };
    const percent = (part: number): string => `${(100 * part).toFixed(1)} %`;
    return html`<button
      type="button"
      class="point"
      data-point=${index}
      aria-label=${msg(str`Point ${String(index + 1)} of ${String(shape.points.length)} of ${shape.name}: ${percent(x)} from the left, ${percent(y)} from the top`)}
      title=${msg("Drag, or arrow keys; + adds a point, Delete takes it away")}
      ${styled(placeOf(spot))}
      @keydown=${press}
      @pointerdown=${hold}
      @pointermove=${this.onDrag}
      @pointerup=${this.onDrop}
      @pointercancel=${this.onDrop}
    ></button>`;
  }

  // ── by pointer ──

  private beginDrag(event: PointerEvent, shape: number, point: number): void {
    if (event.button !== 0) return;
    if (shape !== this.chosen) {
      // The first press only chooses: who means another one moves nothing by mistake.
      this.report({ what: "choose", shape });
      return;
    }
    (event.currentTarget as Element).setPointerCapture(event.pointerId);
    this.drag = { pointer: event.pointerId, point, from: this.partOf(event), along: false };
  }

  private readonly onDrag = (event: PointerEvent): void => {
    const { drag, chosen } = this;
    if (drag?.pointer !== event.pointerId) return;
    const to = this.partOf(event);
    const { along, from, point } = drag;
    if (to[0] === from[0] && to[1] === from[1]) return;
    if (point >= 0) this.report({ what: "move point", shape: chosen, point, to, along });
    else this.report({ what: "move", shape: chosen, dx: to[0] - from[0], dy: to[1] - from[1], along });
    drag.from = to;
    drag.along = true;
  };

  private readonly onDrop = (event: PointerEvent): void => {
    if (this.drag?.pointer === event.pointerId) this.drag = null;
  };

  private partOf(event: PointerEvent): PicturePoint {
    const { left, top } = this.getBoundingClientRect();
    return partAt({ x: event.clientX - left, y: event.clientY - top }, this.view.size, this.picture, this.zoom);
  }

  private viewed(points: readonly PicturePoint[]): ViewPoint[] {
    return viewPoints(points, this.view.size, this.picture, this.zoom);
  }

  // ── by keyboard ──

  private onPointKey(event: KeyboardEvent, point: number): void {
    const { chosen } = this;
    const at = this.shapes[chosen]?.points[point];
    if (at === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    const way = WAYS[event.key];
    if (way !== undefined) {
      const step = event.shiftKey ? LONG_STEP : STEP;
      this.report({ what: "move point", shape: chosen, point, to: [at[0] + way[0] * step, at[1] + way[1] * step], along: event.repeat });
    } else if (event.key === "Delete" || event.key === "Backspace") {
      this.report({ what: "delete point", shape: chosen, point });
      this.focusPoint(Math.max(0, point - 1));
    } else if (event.key === "+" || event.key === "Insert") {
      this.report({ what: "add point", shape: chosen, after: point });
      this.focusPoint(point + 1);
    } else return;
    event.preventDefault();
  }

  private onShapeKey(event: KeyboardEvent, shape: number): void {
    const way = WAYS[event.key];
    if (way === undefined || shape !== this.chosen || event.ctrlKey || event.metaKey || event.altKey) return;
    const step = event.shiftKey ? LONG_STEP : STEP;
    this.report({ what: "move", shape, dx: way[0] * step, dy: way[1] * step, along: event.repeat });
    event.preventDefault();
  }

  private report(edit: ShapeEdit): void {
    this.dispatchEvent(new CustomEvent<ShapeEdit>("t-shape-edit", { detail: edit }));
  }
}

/** On the last piece of a line, a third of it before its end. */
function nearEnd(points: readonly ViewPoint[]): ViewPoint {
  const [from, to] = [points.at(-2) ?? { x: 0, y: 0 }, points.at(-1) ?? { x: 0, y: 0 }];
  return { x: to.x + (from.x - to.x) * 0.3, y: to.y + (from.y - to.y) * 0.3 };
}

function placeOf({ x, y }: ViewPoint): { left: string; top: string } {
  return { left: `${x.toFixed(1)}px`, top: `${y.toFixed(1)}px` };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-shape-handles": ShapeHandles;
  }
  interface HTMLElementEventMap {
    "t-shape-edit": CustomEvent<ShapeEdit>;
  }
}
