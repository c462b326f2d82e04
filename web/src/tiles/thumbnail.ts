/** A small live picture, one a second at the most, and only while it is in view. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { base } from "../elements/base/base-style.js";
import { JpegStream } from "../elements/camera/jpeg-stream.js";
import { mediaPath } from "../wire/media-socket.js";
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
        text-align: center;
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
  private pictures: JpegStream | null = null;
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
    this.pictures = new JpegStream(path, {
      onPicture: (bitmap) => {
        this.draw(bitmap);
      },
      onSpoilt: () => undefined,
      onTrouble: (why) => {
        this.lose(why);
      },
      onLost: (why) => {
        this.lose(why);
      },
    });
    this.pictures.setLowRate(true);
  }

  private close(): void {
    this.pictures?.close();
    [this.pictures, this.opened] = [null, ""];
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
