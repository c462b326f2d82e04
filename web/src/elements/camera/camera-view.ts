/**
 * A camera's picture with its age on it. It never looks live when it is not.
 *
 * Long, because what lies over the picture, and looking closer at it, share one box and its styles.
 */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { formatMs } from "../../format/duration.js";
import { base } from "../base/base-style.js";
import "./detection-boxes.js";
import type { FramedObject } from "./detection-boxes.js";
import "./picture-marks.js";
import type { PictureMark } from "./mark-shapes.js";
import "./model-overlay.js";
import type { PictureOverlay } from "./overlay-layer.js";
import type { PixelSize } from "./picture-fit.js";
import "../base/icon.js";
import type { IconName } from "../base/icons.js";
import { onPicture } from "./picture-overlay.js";
import "../feedback/loading.js";
import { styled } from "../base/style-directive.js";
import { pictureState } from "./picture-state.js";
import { MOST_ZOOM, movedZoom, wheelFactor, WHOLE, zoomedAt, type Zoom } from "./zoom.js";

/** What stands between the page and a picture; `open` when nothing does. */
export type CameraLink = "connecting" | "open" | "bad" | "none" | "offline" | "refused" | "unsupported";

const WORDS: Readonly<Record<CameraLink, { icon: IconName; heading: string; more: string }>> = {
  connecting: { icon: "camera", heading: msg("Connecting to the camera"), more: "" },
  open: { icon: "camera", heading: msg("No picture yet"), more: msg("The camera has not sent one so far.") },
  bad: { icon: "warn", heading: msg("The camera’s picture cannot be shown"), more: "" },
  none: {
    icon: "camera",
    heading: msg("No camera"),
    more: msg("The site description names no picture for this device. Drive only what you can see."),
  },
  offline: { icon: "unlinked", heading: msg("The site is offline"), more: msg("The picture returns with it.") },
  refused: { icon: "lock", heading: msg("This picture is not yours to see"), more: "" },
  unsupported: { icon: "warn", heading: msg("This browser cannot show the picture"), more: "" },
};

const DOT = "M6 1a5 5 0 1 0 0 10A5 5 0 0 0 6 1Z";
const BLOCK = "M1 1h10v10H1z";

/** How the picture lies in the view. */
export interface PictureFit {
  readonly picture: PixelSize;
  readonly zoom: Zoom;
}

/**
 * @slot top - lies over the picture's upper edge
 * @slot hud - lies over it above the lower edge; what stands there takes no pointer
 * @slot tool - more buttons beside its own
 * @slot over - lies over all of the picture, which is `editing` then
 * @fires t-fullscreen the button was pressed
 * @fires t-picture-fit the picture lies in another way: detail is how, a `PictureFit`
 */
@customElement("t-camera-view")
export class CameraView extends LitElement {
  static override styles = [
    base,
    onPicture,
    css`
      :host {
        display: block;
        position: relative;
        overflow: hidden;
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius);
        background: var(--t-raised);
        aspect-ratio: 4 / 3;
        container-type: inline-size;
      }
      .lens {
        position: absolute;
        inset: 0;
        overflow: hidden;
        /* One finger scrolls the page; two, and one once it is zoomed, are for the picture. */
        touch-action: pan-x pan-y;
      }
      .lens.near {
        touch-action: none;
        cursor: grab;
      }
      canvas {
        display: block;
        transform-origin: 0 0;
        inline-size: 100%;
        block-size: 100%;
        object-fit: contain;
        background: #000;
        filter: var(--t-picture-filter, none);
      }
      .aged canvas {
        filter: grayscale(1) brightness(0.55) contrast(0.8);
      }
      .hud {
        position: absolute;
        inset: auto var(--t-space-2) calc(var(--t-touch) + 2 * var(--t-space-2));
        pointer-events: none;
      }
      .veil t-icon {
        font-size: 2.5rem;
        color: var(--t-muted);
      }
      /* Where there is little room, the numbers over the picture lie below these words. */
      @container (max-width: 30rem) {
        div:not(.aged) > .veil {
          align-content: start;
          padding-block-start: calc(var(--t-touch) + 2 * var(--t-space-2));
        }
        div:not(.aged) > .veil t-icon {
          font-size: 1.5rem;
        }
        /* Without a picture the numbers stand in the foot, beside its button, and the words above. */
        .bare > .veil {
          gap: var(--t-space-1);
          padding-block: calc(var(--t-touch) + var(--t-space-2));
        }
        .bare > .veil p {
          font-size: var(--t-size-s);
        }
        .bare > .hud {
          inset: auto calc(var(--t-touch) + 2 * var(--t-space-2)) var(--t-space-2) var(--t-space-2);
        }
      }
      /* Stripes over an old picture: grey alone is easily missed on a grey scene. */
      .heading {
        font-weight: var(--t-weight-strong);
      }
      .aged .veil {
        background: repeating-linear-gradient(
          -45deg,
          rgb(0 0 0 / 30%) 0 14px,
          rgb(0 0 0 / 6%) 14px 28px
        );
      }
      .plate {
        display: grid;
        gap: var(--t-space-1);
        padding: var(--t-space-3) var(--t-space-4);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        border: 2px solid var(--t-bad);
      }
      .plate strong {
        color: var(--t-bad);
        font-size: var(--t-size-l);
        font-variant-numeric: tabular-nums;
      }
      .plate p {
        color: var(--t-text);
      }
      .tools {
        display: flex;
        flex-wrap: wrap-reverse;
        justify-content: end;
        gap: var(--t-space-1);
      }
      @container (inline-size < 26rem) {
        .tools .wide {
          display: none;
        }
      }
      .key[disabled] {
        color: var(--t-muted);
        cursor: default;
      }
      .foot {
        position: absolute;
        inset: auto 0 0;
        display: flex;
        align-items: end;
        justify-content: space-between;
        gap: var(--t-space-2);
        padding: var(--t-space-2);
        pointer-events: none;
      }
      .head {
        position: absolute;
        inset: 0 0 auto;
        /* The foot's buttons stay free. */
        max-block-size: calc(100% - var(--t-touch) - var(--t-space-3));
        display: grid;
        grid-template-rows: minmax(0, 1fr);
        pointer-events: none;
      }
      .badge svg {
        inline-size: 0.75em;
        block-size: 0.75em;
        color: var(--t-ok);
      }
      .aged .badge svg {
        color: var(--t-bad);
      }
      .age {
        display: inline-block;
        min-inline-size: 4.2em;
        font-weight: var(--t-weight-strong);
      }
    `,
  ];

  @property() link: CameraLink = "connecting";
  /** Why it is refused or not supported, in the hub's words. */
  @property() why = "";
  /** What the camera is called. */
  @property() name = "";
  /** Age of the picture on screen (ms); NaN: there is none, or its age is not known. */
  @property({ type: Number }) age = Number.NaN;
  /** When the picture on screen was taken (µs since the epoch, UTC). */
  @property({ type: Number }) time = 0;
  /** It is smaller than the camera's own, since the connection is slow. */
  @property({ type: Boolean }) small = false;
  /** Pictures a second that came in of late. */
  @property({ type: Number }) rate = 0;
  /** A picture has been drawn since the camera was opened. */
  @property({ type: Boolean }) drawn = false;
  @property({ type: Boolean }) full = false;
  /** It shows single exposures, each as it was taken: no film that could stand still. */
  @property({ type: Boolean }) still = false;
  /** What is framed on the picture. */
  @property({ attribute: false }) things: readonly FramedObject[] = [];
  /** Its zones and lines. */
  @property({ attribute: false }) marks: readonly PictureMark[] = [];
  /** What models tell of it. */
  @property({ attribute: false }) overlays: readonly PictureOverlay[] = [];
  /** Something is drawn over it: its own buttons and marks are out of the way. */
  @property({ type: Boolean }) editing = false;
  /** It was seen on an earlier picture than the one that is shown. */
  @property({ type: Boolean }) earlier = false;

  @query("canvas") private readonly canvas!: HTMLCanvasElement;

  @state() private zoom: Zoom = WHOLE;
  @state() private picture: PixelSize = { width: 4, height: 3 };
  /** Fingers and pressed buttons on the picture, where they are now. */
  private readonly held = new Map<number, { x: number; y: number }>();

  /** Shows a picture and takes it over: it is gone afterwards. */
  drawPicture(picture: ImageBitmap | VideoFrame): void {
    const { canvas } = this;
    const film = "displayWidth" in picture;
    const width = film ? picture.displayWidth : picture.width;
    const height = film ? picture.displayHeight : picture.height;
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    if (this.picture.width !== width || this.picture.height !== height) this.picture = { width, height };
    canvas.getContext("2d", { alpha: false })?.drawImage(picture, 0, 0);
    picture.close();
  }

  override updated(changed: Map<PropertyKey, unknown>): void {
    if (!changed.has("picture") && !changed.has("zoom")) return;
    const detail: PictureFit = { picture: this.picture, zoom: this.zoom };
    this.dispatchEvent(new CustomEvent("t-picture-fit", { detail, bubbles: true, composed: true }));
  }

  override render(): TemplateResult {
    const seen = pictureState({ still: this.still, drawn: this.drawn, isOpen: this.link === "open", ageMs: this.age });
    const [live, exposure] = [seen === "live", seen === "exposure"];
    return html`<div class=${this.drawn ? (live || exposure ? "" : "aged") : "bare"}>
      ${this.renderZoomed(live)} ${this.drawn ? html`<div class="tint"></div>` : nothing}
      ${this.drawn && this.overlays.length > 0 && !this.editing
        ? html`<t-model-overlay .overlays=${this.overlays} .picture=${this.picture} .zoom=${this.zoom}></t-model-overlay>`
        : nothing}
      ${this.drawn && this.marks.length > 0 && !this.editing
        ? html`<t-picture-marks .marks=${this.marks} .picture=${this.picture} .zoom=${this.zoom}></t-picture-marks>`
        : nothing}
      ${this.drawn && this.things.length > 0
        ? html`<t-boxes .things=${this.things} ?earlier=${this.earlier} .picture=${this.picture} .zoom=${this.zoom}></t-boxes>`
        : nothing}
      ${live || exposure || (this.editing && this.drawn) ? nothing : this.renderPlaceholder()}
      ${this.editing ? html`<slot name="over"></slot>` : html`<div class="head"><slot name="top"></slot></div>`}
      <div class="hud"><slot name="hud"></slot></div>
      <div class="foot">${this.drawn ? this.renderBadge(live) : html`<span></span>`} ${this.editing ? nothing : this.renderTools()}</div>
    </div>`;
  }

  private renderZoomed(live: boolean): TemplateResult {
    const { scale, x, y } = this.zoom;
    const near = scale > 1;
    const style = near ? { transform: `translate(${String(x * 100)}%, ${String(y * 100)}%) scale(${String(scale)})` } : {};
    return html`<div
      class="lens ${near ? "near" : ""}"
      ?hidden=${!this.drawn}
      tabindex="0"
      role="group"
      aria-label=${msg("Picture; plus and minus zoom, zero shows all of it")}
      @wheel=${this.onWheel}
      @pointerdown=${this.onPointerDown}
      @pointermove=${this.onPointerMove}
      @pointerup=${this.onPointerUp}
      @pointercancel=${this.onPointerUp}
      @dblclick=${this.resetZoom}
      @keydown=${this.onKeyDown}
    >
      <canvas role="img" aria-label=${this.spokenState(live)} ${styled(style)}></canvas>
    </div>`;
  }

  // ── looking closer ──

  private zoomBy(factor: number, x = 0.5, y = 0.5): void {
    this.zoom = zoomedAt(this.zoom, factor, x, y);
  }

  private readonly resetZoom = (): void => {
    this.zoom = WHOLE;
  };

  private pointerPosition(event: MouseEvent): { x: number; y: number; width: number; height: number } {
    const box = this.getBoundingClientRect();
    return { x: (event.clientX - box.x) / box.width, y: (event.clientY - box.y) / box.height, width: box.width, height: box.height };
  }

  private readonly onWheel = (event: WheelEvent): void => {
    // Otherwise the wheel is the page's: it scrolls past the picture.
    if (!event.ctrlKey && !event.metaKey && !this.full && this.zoom.scale === 1) return;
    event.preventDefault();
    const { x, y } = this.pointerPosition(event);
    this.zoomBy(wheelFactor(event.deltaY * (event.deltaMode === 1 ? 33 : 1)), x, y);
  };

  private readonly onPointerDown = (event: PointerEvent): void => {
    this.held.set(event.pointerId, this.pointerPosition(event));
    if (this.zoom.scale > 1 || this.held.size > 1) (event.currentTarget as Element).setPointerCapture(event.pointerId);
  };

  private readonly onPointerMove = (event: PointerEvent): void => {
    const before = this.held.get(event.pointerId);
    if (before === undefined) return;
    const now = this.pointerPosition(event);
    this.held.set(event.pointerId, now);
    const other = [...this.held].find(([id]) => id !== event.pointerId)?.[1];
    if (other === undefined) {
      this.zoom = movedZoom(this.zoom, now.x - before.x, now.y - before.y);
      return;
    }
    const distanceTo = (point: { x: number; y: number }): number =>
      Math.hypot((point.x - other.x) * now.width, (point.y - other.y) * now.height);
    this.zoomBy(distanceTo(now) / Math.max(1, distanceTo(before)), (now.x + other.x) / 2, (now.y + other.y) / 2);
    this.zoom = movedZoom(this.zoom, (now.x - before.x) / 2, (now.y - before.y) / 2);
  };

  private readonly onPointerUp = (event: PointerEvent): void => {
    this.held.delete(event.pointerId);
  };

  private readonly onKeyDown = (event: KeyboardEvent): void => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "+" || event.key === "=") this.zoomBy(1.5);
    else if (event.key === "-") this.zoomBy(1 / 1.5);
    else if (event.key === "0") this.resetZoom();
    else return;
    event.preventDefault();
  };

  // ── keeping one ──

  private readonly saveSnapshot = (): void => {
    this.canvas.toBlob((blob) => {
      if (blob === null) return;
      const link = document.createElement("a");
      link.href = URL.createObjectURL(blob);
      link.download = snapshotName(this.name, this.time);
      link.click();
      setTimeout(() => {
        URL.revokeObjectURL(link.href);
      }, 1000);
    }, "image/png");
  };

  private spokenState(live: boolean): string {
    const name = this.name || msg("Camera");
    if (this.still) return msg(str`${name}, newest exposure, not live`);
    return live ? msg(str`${name}, live picture`) : msg(str`${name}, old picture, not live`);
  }

  private renderPlaceholder(): TemplateResult {
    if (this.drawn) return this.renderFrozen();
    if (this.link === "connecting") {
      return html`<div class="veil"><t-loading what=${msg("Connecting to the camera")}></t-loading></div>`;
    }
    const words = WORDS[this.link];
    return html`<div class="veil">
      <t-icon name=${words.icon}></t-icon>
      <p class="heading">${words.heading}</p>
      <p>${this.why || words.more}</p>
    </div>`;
  }

  private renderFrozen(): TemplateResult {
    const known = Number.isFinite(this.age);
    const cause = this.link === "open" ? msg("Nothing newer has come.") : this.why || `${WORDS[this.link].heading}.`;
    return html`<div class="veil">
      <div class="plate" role="status">
        <strong>${msg("Frozen: not live")}</strong>
        <p>
          ${known
            ? html`${msg(html`The picture is <span aria-live="off">${ageText(this.age)}</span> old.`)} ${cause}`
            : msg(str`The age of the picture is not known. ${cause}`)}
        </p>
      </div>
    </div>`;
  }

  private renderBadge(live: boolean): TemplateResult {
    const age = Number.isFinite(this.age) ? ageText(this.age) : msg("age unknown");
    return html`<span class="badge">
      <svg viewBox="0 0 12 12" aria-hidden="true"><path d=${live ? DOT : BLOCK} fill="currentColor"></path></svg>
      <span>${live ? msg("Live") : this.still ? msg("Exposure") : msg("Old")}</span>
      <span class="age">${age}</span>
      ${live ? html`<span class="muted">${this.rate.toFixed(0)}/s · ${String(this.picture.width)}×${String(this.picture.height)}${this.small ? msg(", small: slow connection") : ""}</span>` : nothing}
    </span>`;
  }

  private renderTools(): TemplateResult {
    const { scale } = this.zoom;
    return html`<div class="tools">
      ${this.drawn
        ? html`${this.renderTool(msg("Zoom out"), "M5 12h14", () => {
            this.zoomBy(1 / 1.5);
          }, "wide", scale <= 1)}
          ${this.renderTool(msg("Zoom in"), "M5 12h14M12 5v14", () => {
            this.zoomBy(1.5);
          }, "wide", scale >= MOST_ZOOM)}
          ${scale > 1 ? this.renderTool(msg("Show all of the picture"), "M4 4h16v16H4zM9 12h6", this.resetZoom) : nothing}
          ${this.renderTool(msg("Save this picture"), "M12 4v11M7 10l5 5 5-5M5 20h14", this.saveSnapshot)}`
        : nothing}
      <slot name="tool"></slot>
      ${this.renderFullButton()}
    </div>`;
  }

  private renderTool(label: string, path: string, act: () => void, kind = "", off = false): TemplateResult {
    return html`<button type="button" class="key ${kind}" aria-label=${label} title=${label} ?disabled=${off} @click=${act}>
      <svg viewBox="0 0 24 24" aria-hidden="true">
        <path d=${path} fill="none" stroke="currentColor" stroke-width="2" stroke-linecap="round" stroke-linejoin="round"></path>
      </svg>
    </button>`;
  }

  private renderFullButton(): TemplateResult {
    const label = this.full ? msg("Leave full screen") : msg("Full screen");
    const path = this.full ? "M9 4v5H4M15 4v5h5M9 20v-5H4M15 20v-5h5" : "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5";
    return html`<button type="button" class="key" aria-label=${label} title=${label} @click=${this.requestFullScreen}>
      <svg viewBox="0 0 24 24" aria-hidden="true">
        <path d=${path} fill="none" stroke="currentColor" stroke-width="2" stroke-linecap="round"></path>
      </svg>
    </button>`;
  }

  private readonly requestFullScreen = (): void => {
    this.dispatchEvent(new CustomEvent("t-fullscreen", { bubbles: true, composed: true }));
  };
}

/** The file's name: what the camera is called and when the picture was taken (UTC). */
export function snapshotName(name: string, timeUs: number): string {
  const slug = name.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "") || "camera";
  return `${slug}-${new Date(timeUs / 1000).toISOString().replace(/:/g, "-")}.png`;
}

/** Steps of 10 ms, so that the digits can be read. */
function ageText(ms: number): string {
  if (ms >= 1000) return formatMs(ms);
  return `${String(Math.max(0, Math.round(ms / 10) * 10))}\u202fms`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-camera-view": CameraView;
  }
  interface GlobalEventHandlersEventMap {
    "t-picture-fit": CustomEvent<PictureFit>;
  }
}
