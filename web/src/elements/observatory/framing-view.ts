/** A piece of the sky with what a camera shows of it: stars, outlines, and the frame, which is moved by hand or by keys. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, svg, type SVGTemplateResult, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { fixedText } from "../../format/number.js";
import type { SkyFieldShape } from "../../generated/api.js";
import { formatDec, formatRa } from "../../format/sexagesimal.js";
import { radians } from "../../sky/coordinates.js";
import { fieldCorners, type FieldSize, type MosaicPanel } from "../../sky/mosaic.js";
import { fromPlane, toPlane, type PlanePoint, type SkyPoint } from "../../sky/tangent-plane.js";
import { base } from "../base/base-style.js";

/** Half of the drawing, in its own units. */
const HALF = 100;
/** An arrow key moves the frame by this part of its height; with Shift by a tenth of it. */
const KEY_PART = 0.1;
const FINE_PART = 0.1;
const ARROWS: Readonly<Record<string, readonly [right: number, up: number]>> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
/** Objects that are named, of those that are shown: the largest. */
const NAMED = 12;
/** Catalogues write M031 and NGC0224. */
const ZEROS = /^(M|NGC|IC)0*(\d)/;

/** What a picture shows: where its middle is, and where its top points (°). */
export interface SkyFrame {
  readonly centre: SkyPoint;
  readonly angle: number;
}

/** Where the frame was moved to; `done` once it was let go. */
export interface FrameMove {
  readonly centre: SkyPoint;
  readonly done: boolean;
}

/**
 * @fires t-frame-moved detail is a `FrameMove`
 */
@customElement("t-framing-view")
export class FramingView extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
      }
      svg {
        display: block;
        inline-size: 100%;
        max-inline-size: 34rem;
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-sky);
      }
      svg:focus-visible {
        outline: 3px solid var(--t-accent);
        outline-offset: 2px;
      }
      text {
        fill: var(--t-text);
        font-size: 6.4px;
        paint-order: stroke;
        stroke: var(--t-sky);
        stroke-width: 2px;
      }
      /* A hand goes through them to the frame. */
      .names {
        pointer-events: none;
      }
      .star {
        fill: var(--t-star);
      }
      .outline {
        fill: none;
        stroke: var(--t-muted);
        stroke-width: 0.8;
      }
      .other {
        fill: none;
        stroke: var(--t-edge);
        stroke-width: 1;
        stroke-dasharray: 3 2;
      }
      .panel {
        fill: var(--t-accent);
        fill-opacity: 0.08;
        stroke: var(--t-accent);
        stroke-width: 1.2;
      }
      .grip {
        cursor: move;
        /* A finger on the frame moves it; beside it the page scrolls. */
        touch-action: none;
      }
      .top {
        stroke: var(--t-accent);
        stroke-width: 2.6;
      }
      .number {
        text-anchor: middle;
        dominant-baseline: middle;
        fill: var(--t-accent);
        font-weight: var(--t-weight-strong);
      }
      .rose {
        stroke: var(--t-text);
        stroke-width: 0.8;
        fill: none;
      }
    `,
  ];

  /** The middle of the drawing; what is at its edges is a little larger, as on any tangent plane. */
  @property({ attribute: false }) anchor: SkyPoint = { raDeg: 0, decDeg: 0 };
  /** How much of the sky is drawn from side to side (°). */
  @property({ type: Number }) span = 3;
  @property({ attribute: false }) sky: SkyFieldShape | null = null;
  @property({ attribute: false }) field: FieldSize = { width: 1, height: 1 };
  /** The middle of what is moved. */
  @property({ attribute: false }) centre: SkyPoint = { raDeg: 0, decDeg: 0 };
  /** What is moved: one panel, or those of a mosaic. */
  @property({ attribute: false }) panels: readonly MosaicPanel[] = [];
  /** Other requests of the group. */
  @property({ attribute: false }) others: readonly SkyFrame[] = [];
  /** What the frame is about, for those who do not see it. */
  @property() name = "";
  @query("svg") private readonly drawing!: SVGSVGElement;
  /** Where the pointer and the frame's middle were when it was taken hold of (° of the plane). */
  private held: { readonly pointer: PlanePoint; readonly middle: PlanePoint } | null = null;

  override render(): TemplateResult {
    return html`<svg
      viewBox=${`${String(-HALF)} ${String(-HALF)} ${String(2 * HALF)} ${String(2 * HALF)}`}
      tabindex="0"
      role="application"
      aria-roledescription=${msg("map of the sky")}
      aria-label=${this.describeSky()}
      @keydown=${this.onKey}
      @pointermove=${this.onMove}
      @pointerup=${this.onRelease}
      @pointercancel=${this.onRelease}
    >
      ${this.renderStars()} ${this.renderOutlines()} ${map(this.others, ({ centre, angle }) => svg`<path class="other" d=${this.framePath(centre, angle)}></path>`)}
      <g class="grip" @pointerdown=${this.onGrip}>${map(this.panels, (panel) => this.renderPanel(panel))}</g>
      <g class="names">${this.renderNames()}</g>
      ${this.renderRose()}
    </svg>`;
  }

  private renderStars(): SVGTemplateResult[] {
    const stars = this.sky?.stars ?? [];
    const faintest = Math.max(...stars.map(({ magnitude }) => magnitude), 6);
    return stars.flatMap(({ ra_deg: raDeg, dec_deg: decDeg, magnitude }) => {
      const at = this.drawnAt({ raDeg, decDeg });
      if (at === null) return [];
      const size = Math.min(3.6, 0.7 + 0.42 * Math.max(0, faintest - magnitude));
      return [svg`<circle class="star" cx=${at.x} cy=${at.y} r=${size.toFixed(2)}><title>${msg(str`${fixedText(magnitude, 1)} mag`)}</title></circle>`];
    });
  }

  private renderOutlines(): SVGTemplateResult[] {
    return (this.sky?.objects ?? []).flatMap(({ name, also, kind, ra_deg: raDeg, dec_deg: decDeg, major, minor, angle }) => {
      const centre = { raDeg, decDeg };
      const at = this.drawnAt(centre);
      if (at === null) return [];
      const [long, short] = [Math.max(1.5, ((major ?? 0) / this.span) * HALF), Math.max(1, ((minor ?? major ?? 0) / this.span) * HALF)];
      // East is to the left: an angle from north through east turns against the clock.
      const title = [name, ...also].map(shortName).join(", ");
      return [svg`<ellipse class="outline" cx=${at.x} cy=${at.y} rx=${short.toFixed(2)} ry=${long.toFixed(2)} transform=${`rotate(${String(-angle)} ${String(at.x)} ${String(at.y)})`}><title>${title}: ${kind}</title></ellipse>`];
    });
  }

  /** At the northern end of each, where a frame about its middle does not cover them. */
  private renderNames(): SVGTemplateResult[] {
    return (this.sky?.objects ?? []).slice(0, NAMED).flatMap(({ name, also, ra_deg: raDeg, dec_deg: decDeg, major, angle }) => {
      const at = this.drawnAt({ raDeg, decDeg }, HALF);
      if (at === null) return [];
      const long = Math.max(1.5, ((major ?? 0) / this.span) * HALF);
      const [x, y] = [at.x - long * Math.sin(radians(angle)), at.y - long * Math.cos(radians(angle))];
      const inside = (value: number, low: number, high: number): string => Math.max(low, Math.min(high, value)).toFixed(1);
      return [svg`<text x=${inside(x + 1, 2 - HALF, HALF - 22)} y=${inside(y - 2, 7 - HALF, HALF - 3)}>${shortName(also[0] ?? name)}</text>`];
    });
  }

  private renderPanel({ centre, angle, row, column }: MosaicPanel): SVGTemplateResult {
    const at = this.drawnAt(centre, Number.POSITIVE_INFINITY);
    const [left, right] = fieldCorners(centre, this.field, angle).map((corner) => this.drawnAt(corner, Number.POSITIVE_INFINITY));
    // Which side is up is seen only where the panel is turned.
    const top = left == null || right == null ? nothing : svg`<path class="top" d=${`M${String(left.x)} ${String(left.y)}L${String(right.x)} ${String(right.y)}`}></path>`;
    const number = this.panels.length > 1 && at !== null ? svg`<text class="number" x=${at.x} y=${at.y}>${row}-${column}</text>` : nothing;
    return svg`<path class="panel" d=${this.framePath(centre, angle)}></path>${top}${number}`;
  }

  /** North and east, and how long a piece of the sky is. */
  private renderRose(): SVGTemplateResult {
    const length = niceLength(this.span / 4);
    const units = (length / this.span) * 2 * HALF;
    const words = length >= 1 ? `${String(length)}°` : `${String(Math.round(length * 60))}′`;
    return svg`<g transform="translate(${HALF - 8} ${HALF - 8})">
        <path class="rose" d="M0 0V-14M0 0H-14"></path>
        <text x="-2.2" y="-16">N</text><text x="-20" y="2.2">E</text>
      </g>
      <path class="rose" d=${`M${String(6 - HALF)} ${String(HALF - 11)}v3h${units.toFixed(1)}v-3`}></path>
      <text x=${7 - HALF} y=${HALF - 12}>${words}</text>`;
  }

  private framePath(centre: SkyPoint, angle: number): string {
    const corners = fieldCorners(centre, this.field, angle).map((corner) => this.drawnAt(corner, Number.POSITIVE_INFINITY));
    return corners.some((corner) => corner === null) ? "" : `M${corners.map((corner) => `${String(corner?.x)} ${String(corner?.y)}`).join("L")}Z`;
  }

  /** Where something is drawn; null when that is out of the drawing. */
  private drawnAt(point: SkyPoint, margin = 1.3 * HALF): { readonly x: number; readonly y: number } | null {
    const at = toPlane(point, this.anchor);
    if (at === null) return null;
    const round = (value: number): number => Math.round(value * 100) / 100;
    const [x, y] = [round((-at.east / this.span) * 2 * HALF), round((-at.north / this.span) * 2 * HALF)];
    return Math.abs(x) > margin || Math.abs(y) > margin ? null : { x, y };
  }

  /** A pointer's place on the plane (°). */
  private pointerAt(event: PointerEvent): PlanePoint {
    const box = this.drawing.getBoundingClientRect();
    if (box.width === 0) return { east: 0, north: 0 };
    const scale = this.span / box.width;
    return { east: (box.x + box.width / 2 - event.clientX) * scale, north: (box.y + box.height / 2 - event.clientY) * scale };
  }

  private readonly onGrip = (event: PointerEvent): void => {
    const middle = toPlane(this.centre, this.anchor);
    if (event.button !== 0 || middle === null) return;
    // Without it a phone would select text; the focus comes by itself no more.
    event.preventDefault();
    this.drawing.focus();
    this.drawing.setPointerCapture(event.pointerId);
    this.held = { pointer: this.pointerAt(event), middle };
  };

  private readonly onMove = (event: PointerEvent): void => {
    this.moveHeld(event, false);
  };

  private readonly onRelease = (event: PointerEvent): void => {
    this.moveHeld(event, true);
    this.held = null;
  };

  private moveHeld(event: PointerEvent, done: boolean): void {
    if (this.held === null) return;
    const { pointer, middle } = this.held;
    const at = this.pointerAt(event);
    this.moveTo({ east: middle.east + at.east - pointer.east, north: middle.north + at.north - pointer.north }, done);
  }

  private readonly onKey = (event: KeyboardEvent): void => {
    const arrow = ARROWS[event.key];
    const middle = toPlane(this.centre, this.anchor);
    if (arrow === undefined || middle === null || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    const step = this.field.height * KEY_PART * (event.shiftKey ? FINE_PART : 1);
    // What is to the right is west.
    this.moveTo({ east: middle.east - arrow[0] * step, north: middle.north + arrow[1] * step }, true);
  };

  private moveTo(at: PlanePoint, done: boolean): void {
    const detail: FrameMove = { centre: fromPlane(at, this.anchor), done };
    this.dispatchEvent(new CustomEvent("t-frame-moved", { detail }));
  }

  private describeSky(): string {
    const { panels, sky } = this;
    const what = panels.length > 1 ? msg(str`A mosaic of ${String(panels.length)} panels`) : msg("The frame");
    const inside = (sky?.objects ?? []).slice(0, 4).map(({ name, also }) => shortName(also[0] ?? name));
    const near = inside.length === 0 ? "" : msg(str` Near it: ${inside.join(", ")}.`);
    return msg(str`${what} about ${this.name === "" ? "" : `${this.name}, `}${formatRa(this.centre.raDeg / 15)} ${formatDec(this.centre.decDeg)}.${near} Arrow keys move it, with Shift a little.`);
  }
}

/** As people write it: M 31, NGC 224. */
export function shortName(name: string): string {
  return name.replace(ZEROS, "$1 $2");
}

/** A round length that is no longer. */
function niceLength(most: number): number {
  return [20, 10, 5, 2, 1, 30 / 60, 20 / 60, 10 / 60, 5 / 60, 2 / 60, 1 / 60].find((length) => length <= most) ?? 1 / 60;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-framing-view": FramingView;
  }
  interface GlobalEventHandlersEventMap {
    "t-frame-moved": CustomEvent<FrameMove>;
  }
}
