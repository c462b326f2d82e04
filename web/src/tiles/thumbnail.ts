/** A small live picture, one a second at the most, and only while it is in view. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { base } from "../elements/base/base-style.js";
import { MediaSocket, mediaPath, socketUrl } from "../wire/media-socket.js";
import { JpegPlayer } from "../elements/camera/jpeg-player.js";
import "../elements/base/icon.js";

@customElement("t-thumbnail")
export class Thumbnail extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        position: relative;
        display: grid;
        place-items: center;
        aspect-ratio: 16 / 9;
        overflow: hidden;
        border-radius: var(--t-radius-s);
        background: var(--t-raised);
        color: var(--t-muted);
        font-size: var(--t-size-s);
      }
      canvas {
        position: absolute;
        inset: 0;
        inline-size: 100%;
        block-size: 100%;
        object-fit: cover;
        filter: var(--t-picture-filter, none);
      }
      .tint {
        display: var(--t-picture-tinted, none);
        position: absolute;
        inset: 0;
        mix-blend-mode: multiply;
        background: var(--t-picture-tint, transparent);
      }
    `,
  ];

  @property() site = "";
  /** `device/stream` */
  @property() stream = "";
  @property() label = "";
  @property({ type: Boolean }) online = true;
  @state() private drawn = false;
  @state() private why = "";
  @query("canvas") private readonly canvas!: HTMLCanvasElement;

  private inView = false;
  private opened = "";
  private socket: MediaSocket | null = null;
  private player: JpegPlayer | null = null;
  private readonly watcher = new IntersectionObserver((entries) => {
    this.inView = entries.at(-1)?.isIntersecting ?? false;
    this.requestUpdate();
  });

  override connectedCallback(): void {
    super.connectedCallback();
    this.watcher.observe(this);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.watcher.disconnect();
    this.inView = false;
    this.close();
  }

  override willUpdate(): void {
    const wanted = this.inView && this.online && this.stream !== "" ? mediaPath(this.site, this.stream, ["jpeg"]) : "";
    if (wanted === this.opened) return;
    this.close();
    this.opened = wanted;
    if (wanted !== "") this.open(wanted);
  }

  override render(): TemplateResult {
    const word = this.drawn ? "" : this.online ? this.why || msg("Waiting for a picture") : msg("Offline");
    return html`<canvas ?hidden=${!this.drawn} role="img" aria-label=${this.label}></canvas>
      <span class="tint" aria-hidden="true"></span>
      ${word === "" ? nothing : html`<span>${word}</span>`}`;
  }

  private open(path: string): void {
    const player = new JpegPlayer({
      // The bytes are a view on one frame of the socket, which is ours alone.
      decode: ({ data }) => createImageBitmap(new Blob([data as Uint8Array<ArrayBuffer>])),
      draw: (bitmap) => {
        this.draw(bitmap);
      },
      failed: () => undefined,
    });
    this.player = player;
    this.socket = new MediaSocket(
      { url: socketUrl(path, location) },
      {
        onShot: (shot, shown) => {
          player.receivePicture(shot, shown);
        },
        onTrouble: (why) => {
          this.lose(why);
        },
        onState: (state, why) => {
          // What was drawn is old now: an old picture is never shown as a new one.
          if (state !== "open") this.lose(why);
        },
      },
    );
    this.socket.setLowRate(true);
  }

  private close(): void {
    this.socket?.close();
    this.player?.close();
    [this.socket, this.player, this.opened] = [null, null, ""];
    this.drawn = false;
  }

  private lose(why: string): void {
    this.drawn = false;
    this.why = why;
  }

  private draw(bitmap: ImageBitmap): void {
    this.canvas.width = bitmap.width;
    this.canvas.height = bitmap.height;
    this.canvas.getContext("2d")?.drawImage(bitmap, 0, 0);
    bitmap.close();
    this.drawn = true;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-thumbnail": Thumbnail;
  }
}
