/** Says that a camera's picture is blurred, and shows it as it is to those who may see that. */

import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import { onPicture } from "../../elements/camera/picture-overlay.js";

const EXPLAINED = msg("Faces, and what else the site’s description names, are blurred before the picture leaves its gateway.");

/** @fires t-unblur the button was pressed: detail is whether the picture is wanted as it is */
@customElement("t-blur-button")
export class BlurButton extends LitElement {
  static override styles = [
    base,
    onPicture,
    css`
      :host {
        display: inline-flex;
        align-items: center;
      }
      .key[aria-pressed="true"] {
        border: 2px solid var(--t-bad);
      }
      .badge {
        min-block-size: var(--t-touch);
        pointer-events: auto;
      }
    `,
  ];

  /** This person may see the picture as it is. */
  @property({ type: Boolean }) may = false;
  /** It is shown as it is. */
  @property({ type: Boolean }) unblurred = false;

  override render(): TemplateResult {
    if (!this.may) return html`<span class="badge" title=${EXPLAINED}>${msg("Blurred")}</span>`;
    const label = this.unblurred ? msg("Show it blurred again") : msg("Show it unblurred; the audit log will say that you did");
    return html`<button
      type="button"
      class="key worded"
      aria-label=${`${this.word}. ${label}`}
      aria-pressed=${this.unblurred ? "true" : "false"}
      title=${`${EXPLAINED} ${label}.`}
      @click=${this.toggle}
    >
      ${this.word}
    </button>`;
  }

  private get word(): string {
    return this.unblurred ? msg("Unblurred") : msg("Blurred");
  }

  private readonly toggle = (): void => {
    this.dispatchEvent(new CustomEvent("t-unblur", { detail: !this.unblurred }));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-blur-button": BlurButton;
  }
}
