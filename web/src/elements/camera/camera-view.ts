/** A camera's picture with its age on it. It never looks live when it is not. */

import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { formatMs } from "../../format/duration.js";
import { base } from "../base.js";
import "../icon.js";
import type { IconName } from "../icons.js";
import "../loading.js";

/** What stands between the page and a picture; `open` when nothing does. */
export type CameraLink = "connecting" | "open" | "none" | "offline" | "refused" | "unsupported";

/** Older than this it is not live (safety rule 12). */
export const LIVE_MS = 500;

const WORDS: Readonly<Record<CameraLink, { icon: IconName; heading: string; more: string }>> = {
  connecting: { icon: "camera", heading: "Connecting to the camera", more: "" },
  open: { icon: "camera", heading: "No picture yet", more: "The camera has not sent one so far." },
  none: {
    icon: "camera",
    heading: "No camera",
    more: "The site description names no picture for this device. Drive only what you can see.",
  },
  offline: { icon: "unlinked", heading: "The site is offline", more: "The picture returns with it." },
  refused: { icon: "lock", heading: "This picture is not yours to see", more: "" },
  unsupported: { icon: "warn", heading: "This browser cannot show the picture", more: "" },
};

const DOT = "M6 1a5 5 0 1 0 0 10A5 5 0 0 0 6 1Z";
const BLOCK = "M1 1h10v10H1z";

/**
 * @fires t-fullscreen the button was pressed
 */
@customElement("t-camera-view")
export class CameraView extends LitElement {
  static override styles = [
    base,
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
      canvas {
        display: block;
        inline-size: 100%;
        block-size: 100%;
        object-fit: contain;
        background: #000;
        filter: var(--t-picture-filter, none);
      }
      /* Multiplied with the picture: a red tint leaves nothing but red. Only there where a theme
         asks for it: blending costs a pass over the whole picture, 30 times a second. */
      .tint {
        display: var(--t-picture-tinted, none);
        position: absolute;
        inset: 0;
        background: var(--t-picture-tint);
        mix-blend-mode: multiply;
        pointer-events: none;
      }
      .aged canvas {
        filter: grayscale(1) brightness(0.55) contrast(0.8);
      }
      .veil {
        position: absolute;
        inset: 0;
        display: grid;
        place-content: center;
        justify-items: center;
        gap: var(--t-space-2);
        padding: var(--t-space-4);
        text-align: center;
      }
      .veil t-icon {
        font-size: 2.5rem;
        color: var(--t-muted);
      }
      .veil p {
        max-inline-size: 34ch;
        color: var(--t-muted);
      }
      /* Stripes over an old picture: grey alone is easily missed on a grey scene. */
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
      .badge {
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-2);
        padding: 0.2rem var(--t-space-2);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        border: 1px solid var(--t-line);
        font-size: var(--t-size-s);
        font-variant-numeric: tabular-nums;
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
      button {
        pointer-events: auto;
        display: grid;
        place-content: center;
        inline-size: var(--t-touch);
        block-size: var(--t-touch);
        padding: 0;
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        cursor: pointer;
      }
      button svg {
        inline-size: 1.4rem;
        block-size: 1.4rem;
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
  /** Pictures a second that came in of late. */
  @property({ type: Number }) rate = 0;
  /** A picture has been drawn since the camera was opened. */
  @property({ type: Boolean }) drawn = false;
  @property({ type: Boolean }) full = false;

  @query("canvas") private readonly canvas!: HTMLCanvasElement;

  /** Shows a picture and takes it over: the bitmap is gone afterwards. */
  draw(bitmap: ImageBitmap): void {
    const { canvas } = this;
    if (canvas.width !== bitmap.width) canvas.width = bitmap.width;
    if (canvas.height !== bitmap.height) canvas.height = bitmap.height;
    canvas.getContext("bitmaprenderer")?.transferFromImageBitmap(bitmap);
  }

  override render(): TemplateResult {
    const live = this.drawn && this.link === "open" && this.age <= LIVE_MS;
    return html`<div class=${this.drawn && !live ? "aged" : ""}>
      <canvas ?hidden=${!this.drawn} role="img" aria-label=${this.spoken(live)}></canvas>
      ${this.drawn ? html`<div class="tint"></div>` : nothing} ${live ? nothing : this.veil()}
      <div class="foot">${this.drawn ? this.badge(live) : html`<span></span>`} ${this.fullButton()}</div>
    </div>`;
  }

  private spoken(live: boolean): string {
    const name = this.name || "Camera";
    return live ? `${name}, live picture` : `${name}, old picture, not live`;
  }

  private veil(): TemplateResult {
    if (this.drawn) return this.frozen();
    if (this.link === "connecting") {
      return html`<div class="veil"><t-loading what="Connecting to the camera"></t-loading></div>`;
    }
    const words = WORDS[this.link];
    return html`<div class="veil">
      <t-icon name=${words.icon}></t-icon>
      <h3>${words.heading}</h3>
      <p>${this.why || words.more}</p>
    </div>`;
  }

  private frozen(): TemplateResult {
    const known = Number.isFinite(this.age);
    const cause = this.link === "open" ? "Nothing newer has come." : this.why || `${WORDS[this.link].heading}.`;
    return html`<div class="veil">
      <div class="plate" role="status">
        <strong>Frozen: not live</strong>
        <p>
          ${known
            ? html`The picture is <span aria-live="off">${ageWords(this.age)}</span> old. ${cause}`
            : `The age of the picture is not known. ${cause}`}
        </p>
      </div>
    </div>`;
  }

  private badge(live: boolean): TemplateResult {
    const age = Number.isFinite(this.age) ? ageWords(this.age) : "age unknown";
    return html`<span class="badge">
      <svg viewBox="0 0 12 12" aria-hidden="true"><path d=${live ? DOT : BLOCK} fill="currentColor"></path></svg>
      <span>${live ? "Live" : "Old"}</span>
      <span class="age">${age}</span>
      ${live ? html`<span class="muted">${this.rate.toFixed(0)}/s</span>` : nothing}
    </span>`;
  }

  private fullButton(): TemplateResult {
    const label = this.full ? "Leave full screen" : "Full screen";
    const path = this.full ? "M9 4v5H4M15 4v5h5M9 20v-5H4M15 20v-5h5" : "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5";
    return html`<button type="button" aria-label=${label} title=${label} @click=${this.askFull}>
      <svg viewBox="0 0 24 24" aria-hidden="true">
        <path d=${path} fill="none" stroke="currentColor" stroke-width="2" stroke-linecap="round"></path>
      </svg>
    </button>`;
  }

  private readonly askFull = (): void => {
    this.dispatchEvent(new CustomEvent("t-fullscreen", { bubbles: true, composed: true }));
  };
}

/** Steps of 10 ms, so that the digits can be read. */
function ageWords(ms: number): string {
  if (ms >= 1000) return formatMs(ms);
  return `${String(Math.max(0, Math.round(ms / 10) * 10))}\u202fms`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-camera-view": CameraView;
  }
}
