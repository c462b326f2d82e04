/** Beside a picture's other buttons: its zones and lines, shown or not. */

import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import { onPicture } from "../../elements/camera/picture-overlay.js";

@customElement("t-marks-button")
export class MarksButton extends LitElement {
  static override styles = [
    base,
    onPicture,
    css`
      .key[aria-pressed="true"] {
        border-color: var(--t-accent);
        box-shadow: inset 0 0 0 1px var(--t-accent);
        color: var(--t-accent);
      }
    `,
  ];

  @property({ type: Boolean }) on = false;

  override render(): TemplateResult {
    const title = this.on ? msg("Hide zones and lines") : msg("Show zones and lines");
    return html`<button type="button" class="key" aria-label=${msg("Zones and lines")} title=${title} aria-pressed=${this.on ? "true" : "false"}>
      <svg viewBox="0 0 24 24" aria-hidden="true">
        <path d="M4 9l7-5 9 4-3 11-11 1zM4 9h.01M11 4h.01M20 8h.01M17 19h.01M6 20h.01" fill="none" stroke="currentColor" stroke-width="2" stroke-linecap="round" stroke-linejoin="round"></path>
      </svg>
    </button>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-marks-button": MarksButton;
  }
}
