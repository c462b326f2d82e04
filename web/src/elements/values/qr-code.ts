import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../base/base-style.js";

/**
 * A QR code that the hub drew. It is shown as a picture, in which nothing can run, and stays
 * dark on bright in every theme, since many readers know no other.
 */
@customElement("t-qr")
export class QrPicture extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: inline-grid;
        inline-size: min(12.5rem, 100%);
        aspect-ratio: 1;
        padding: var(--t-space-2);
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius-s);
        background: var(--t-paper);
      }
      img {
        inline-size: 100%;
        block-size: 100%;
        object-fit: contain;
        image-rendering: pixelated;
        min-block-size: 0;
      }
    `,
  ];

  /** Text of an SVG picture. */
  @property() svg = "";
  /** What it holds, for who cannot see it. */
  @property() label = msg("QR code");

  override render(): TemplateResult {
    return html`<img alt=${this.label} src=${`data:image/svg+xml;charset=utf-8,${encodeURIComponent(this.svg)}`} />`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-qr": QrPicture;
  }
}
