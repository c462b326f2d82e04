import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { TickerController } from "../../controllers/ticker.js";
import { formatClock, zoneName } from "../../format/time.js";
import { base, quietText } from "../base/base-style.js";

/** What time it is now at a site, with UTC beside it. */
@customElement("t-clock")
export class Clock extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        ${quietText}
        font-variant-numeric: tabular-nums;
        white-space: nowrap;
      }
      .local {
        color: var(--t-text);
        font-weight: var(--t-weight-strong);
      }
    `,
  ];

  /** IANA name. */
  @property() zone = "UTC";

  constructor() {
    super();
    new TickerController(this);
  }

  override render(): TemplateResult {
    const now = Date.now() * 1000;
    const name = zoneName(now, this.zone);
    return html`<span class="local" title=${this.zone}>${formatClock(now, this.zone)} ${name}</span>${name === "UTC" ? nothing : html` · ${formatClock(now, "UTC")} UTC`}`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-clock": Clock;
  }
}
