/** One stream of a site: media socket to canvas, with the picture's age. */

import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { LinkController } from "../../controllers/link.js";
import "../../elements/camera/camera-view.js";
import type { CameraLink, CameraView } from "../../elements/camera/camera-view.js";
import type { Shot } from "../../generated/wire.js";
import { MediaSocket, mediaPath, socketUrl } from "../../wire/media.js";
import { Newest } from "./newest.js";

const MIME: Readonly<Record<string, string>> = { jpeg: "image/jpeg", png: "image/png", webp: "image/webp" };
/** The age on the picture changes this often. */
const AGE_EVERY_MS = 100;
const RATE_WINDOW_MS = 2000;

/**
 * @fires t-picture after each picture: detail is when it was taken, on this page's clock, or null
 */
@customElement("t-camera")
export class Camera extends LitElement {
  static override styles = css`
    :host {
      display: block;
    }
    :host([hidden]) {
      display: none;
    }
  `;

  @property() site = "";
  /** Address of the stream, `device/stream`; empty for none. */
  @property() stream = "";
  @property() name = "";
  @property({ type: Boolean }) online = true;
  @property({ type: Boolean }) full = false;

  @state() private media: CameraLink = "connecting";
  @state() private why = "";
  @state() private takenAt: number | null = null;
  @state() private drawn = false;
  @query("t-camera-view") private readonly view!: CameraView;

  private readonly link = new LinkController(this);
  private socket: MediaSocket | null = null;
  private newest: Newest | null = null;
  private arrivals: number[] = [];
  private timer: ReturnType<typeof setInterval> | undefined;
  private opened = "";

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = setInterval(() => {
      this.requestUpdate();
    }, AGE_EVERY_MS);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
    this.shut();
    this.opened = "";
  }

  override updated(): void {
    // A camera of a site that is away is not asked for over and over.
    const wanted = this.stream !== "" && this.online ? mediaPath(this.site, this.stream) : "";
    if (wanted === this.opened) return;
    this.opened = wanted;
    this.shut();
    if (wanted !== "") this.openSocket(wanted);
  }

  override render(): TemplateResult {
    const now = performance.now();
    const { connection } = this.link;
    const lost = connection !== undefined && connection.state !== "open";
    return html`<t-camera-view
      .link=${this.linkNow()}
      .why=${this.why || (lost ? "The connection to the hub is lost." : "")}
      .name=${this.name}
      .age=${this.takenAt === null ? Number.NaN : now - this.takenAt}
      .rate=${this.rate(now)}
      .drawn=${this.drawn}
      .full=${this.full}
    ></t-camera-view>`;
  }

  private linkNow(): CameraLink {
    if (this.stream === "") return "none";
    return this.online ? this.media : "offline";
  }

  private rate(now: number): number {
    const recent = this.arrivals.filter((at) => now - at < RATE_WINDOW_MS).length;
    return (recent * 1000) / RATE_WINDOW_MS;
  }

  private openSocket(path: string): void {
    this.media = "connecting";
    this.why = "";
    this.drawn = false;
    this.takenAt = null;
    const newest = new Newest({
      decode: (shot) => this.decode(shot),
      draw: (bitmap, shot) => {
        this.draw(bitmap, shot);
      },
      failed: (shot) => {
        if (shot.format in MIME) return;
        this.media = "unsupported";
        this.why = `It comes as ${shot.format}; this page can show ${Object.keys(MIME).join(", ")}.`;
      },
    });
    this.newest = newest;
    this.socket = new MediaSocket(
      { url: socketUrl(path, location) },
      {
        onShot: (shot, shown) => {
          newest.take(shot, shown);
        },
        onState: (state, why) => {
          this.media = state === "open" || state === "refused" ? state : "connecting";
          this.why = state === "lost" ? "The picture's connection is lost; trying again." : why;
        },
      },
    );
  }

  private decode(shot: Shot): Promise<ImageBitmap> {
    const type = MIME[shot.format];
    if (type === undefined) return Promise.reject(new TypeError(shot.format));
    // The bytes are a view on one frame of the socket, which is ours alone.
    return createImageBitmap(new Blob([shot.data as Uint8Array<ArrayBuffer>], { type }));
  }

  private draw(bitmap: ImageBitmap, shot: Shot): void {
    const now = performance.now();
    this.view.draw(bitmap);
    const age = this.link.connection?.ageOf(shot.hub_us) ?? Number.NaN;
    this.takenAt = Number.isFinite(age) ? now - Math.max(0, age) : null;
    this.drawn = true;
    this.arrivals = [...this.arrivals.slice(-120), now];
    this.dispatchEvent(new CustomEvent("t-picture", { detail: this.takenAt }));
  }

  private shut(): void {
    this.socket?.close();
    this.newest?.close();
    this.socket = null;
    this.newest = null;
    this.dispatchEvent(new CustomEvent("t-picture", { detail: null }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-camera": Camera;
  }
  interface GlobalEventHandlersEventMap {
    "t-picture": CustomEvent<number | null>;
  }
}
