import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { timeText } from "../../format/time.js";
import { base } from "../base/base-style.js";

/** A moment in the site's zone, with UTC beside it. */
@customElement("t-time")
export class TimeElement extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        font-variant-numeric: tabular-nums;
      }
      .utc {
        color: var(--t-muted);
        white-space: nowrap;
      }
      .zone {
        font-size: 0.85em;
      }
    `,
  ];

  /** Microseconds since the epoch, UTC; 0 means never. */
  @property({ type: Number }) us = 0;
  /** IANA name. */
  @property() zone = "UTC";
  /** Leaves UTC away where the place is too small; it stays in the title. */
  @property({ type: Boolean }) short = false;

  override render(): TemplateResult {
    if (this.us <= 0) return html`<span>${msg("never")}</span>`;
    const text = timeText(this.us, this.zone, Date.now() * 1000);
    const same = text.zone === "UTC";
    return html`<time datetime=${text.machine} title=${text.utc}
      >${text.local} <span class="zone">${text.zone}</span>${same || this.short ? nothing : html` <span class="utc">(${text.utc})</span>`}</time
    >`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-time": TimeElement;
  }
}
