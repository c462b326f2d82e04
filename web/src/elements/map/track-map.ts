/** Where the vehicle is and was, on a grid in metres. Needs no tiles and no internet. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { base } from "../base/base-style.js";
import "../forms/button.js";
import "../feedback/loading.js";
import type { LocalMap } from "./leaflet.js";
import { mapFrame } from "./map-style.js";
import { paintMap, scaleBar, type Colours, type Pose } from "./map-painter.js";
import { FrameSchedule } from "../base/frame-schedule.js";
import type { TrackPoint } from "./track.js";

@customElement("t-track-map")
export class TrackMap extends LitElement {
  static override styles = [
    base,
    mapFrame,
    css`
      .follow {
        position: absolute;
        z-index: 2;
        inset: var(--t-space-2) var(--t-space-2) auto auto;
      }
    `,
  ];

  @property({ attribute: false }) pose: Pose | null = null;
  /** Of its digital twin; null without one. */
  @property({ attribute: false }) ghost: Pose | null = null;
  @property({ attribute: false }) trail: readonly TrackPoint[] = [];
  /** Why there is no position; shown while `pose` is null. */
  @property() note = msg("Waiting for the first position");
  /** The position is older than its limit, and how old, in words; empty when it is fresh. */
  @property() stale = "";
  /** The position in words, under the map. */
  @property() where = "";

  @state() private follow = true;
  @state() private ready = false;
  @state() private bar = { text: "", px: 0 };
  @query("canvas") private readonly canvas!: HTMLCanvasElement;
  @query(".leaflet") private readonly place!: HTMLElement;
  @query(".scale i") private readonly ruler!: HTMLElement;

  private local: LocalMap | null = null;
  private sizes: ResizeObserver | null = null;
  private themes: MutationObserver | null = null;
  private colours: Colours | null = null;
  private readonly frames = new FrameSchedule(() => {
    this.paintNow();
  });

  override render(): TemplateResult {
    return html`
      <div class="frame">
        <canvas role="img" aria-label=${msg("Grid in metres with the vehicle and its trail")}></canvas>
        <div class="leaflet" data-keys="own" aria-label=${msg("Map: arrow keys move it, plus and minus zoom")}></div>
        <div class="scale" aria-hidden="true" ?hidden=${!this.ready}>${this.bar.text}<i></i></div>
        ${this.ready ? nothing : html`<div class="note"><t-loading what=${msg("Loading the map")}></t-loading></div>`}
        ${this.ready && this.pose === null ? html`<div class="note" role="status">${this.note}</div>` : nothing}
        <t-button class="follow" .pressed=${this.follow ? "true" : "false"} @click=${this.toggleFollow}>
          ${this.follow ? msg("Following") : msg("Follow")}
        </t-button>
        ${this.where === "" && this.stale === ""
          ? nothing
          : html`<div class="where">
              ${this.where} ${this.stale === "" ? nothing : html`<span class="stale" role="status">${this.stale}</span>`}
            </div>`}
      </div>
    `;
  }

  override firstUpdated(): void {
    void this.start();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.sizes?.disconnect();
    this.themes?.disconnect();
    this.local?.map.remove();
    this.local = null;
    this.ready = false;
    this.frames.cancel();
  }

  override connectedCallback(): void {
    super.connectedCallback();
    if (this.hasUpdated) void this.start();
  }

  override updated(changed: PropertyValues<this>): void {
    this.ruler.style.inlineSize = `${this.bar.px.toFixed(0)}px`;
    if (changed.has("pose") && this.follow && this.pose) this.local?.centerOn(this.pose.x, this.pose.y);
    if (changed.has("pose") || changed.has("ghost") || changed.has("trail") || changed.has("stale")) this.scheduleDraw();
  }

  private async start(): Promise<void> {
    const leaflet = await import("./leaflet.js");
    if (!this.isConnected || this.local) return;
    const root = this.renderRoot;
    if (root instanceof ShadowRoot && leaflet.styles.styleSheet) {
      // Before ours, so that our colours win.
      root.adoptedStyleSheets = [leaflet.styles.styleSheet, ...root.adoptedStyleSheets];
    }
    this.local = leaflet.localMap(this.place);
    const { map } = this.local;
    map.on("move zoom viewreset resize", this.scheduleDraw);
    map.on("dragstart", this.stopFollowing);
    this.place.addEventListener("keydown", this.onKeyDown);
    this.sizes = new ResizeObserver(() => {
      map.invalidateSize({ animate: false });
      this.scheduleDraw();
    });
    this.sizes.observe(this.place);
    this.themes = new MutationObserver(this.recolour);
    this.themes.observe(document.documentElement, { attributeFilter: ["data-theme"] });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", this.recolour);
    this.ready = true;
    if (this.pose) this.local.centerOn(this.pose.x, this.pose.y);
    this.scheduleDraw();
  }

  private readonly recolour = (): void => {
    this.colours = null;
    this.scheduleDraw();
  };

  /** Whoever moves the map wants to look elsewhere. */
  private readonly stopFollowing = (): void => {
    this.follow = false;
  };

  private readonly onKeyDown = (event: KeyboardEvent): void => {
    if (event.key.startsWith("Arrow")) this.stopFollowing();
  };

  private readonly toggleFollow = (): void => {
    this.follow = !this.follow;
    if (this.follow && this.pose) this.local?.centerOn(this.pose.x, this.pose.y);
  };

  /** Once for each painted frame of the browser, however many things changed. */
  private readonly scheduleDraw = (): void => {
    this.frames.schedule();
  };

  private paintNow(): void {
    const pen = this.canvas.getContext("2d");
    if (!this.local || !pen) return;
    const { map } = this.local;
    const { x: width, y: height } = map.getSize();
    const ratio = window.devicePixelRatio || 1;
    if (this.canvas.width !== Math.round(width * ratio)) this.canvas.width = Math.round(width * ratio);
    if (this.canvas.height !== Math.round(height * ratio)) this.canvas.height = Math.round(height * ratio);
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    const origin = map.latLngToContainerPoint([0, 0]);
    const scale = map.getZoomScale(map.getZoom(), 0);
    const sight = { width, height, scale, originX: origin.x, originY: origin.y };
    const scene = { trail: this.trail, pose: this.pose, ghost: this.ghost, stale: this.stale !== "" };
    const style = getComputedStyle(this);
    this.colours ??= coloursOf(style);
    paintMap(pen, sight, scene, this.colours, `12px ${style.fontFamily}`);
    const bar = scaleBar(scale);
    if (bar.text !== this.bar.text) this.bar = bar;
  }
}

function coloursOf(style: CSSStyleDeclaration): Colours {
  const token = (name: string): string => style.getPropertyValue(`--t-${name}`).trim();
  return {
    line: token("line"),
    strong: token("edge"),
    text: token("muted"),
    accent: token("accent"),
    stale: token("stale"),
    surface: token("surface"),
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-track-map": TrackMap;
  }
}
