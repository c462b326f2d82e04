/** One site among many, by what the list of sites says: no request of its own, so that hundreds stand at once. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { ConnectionStateController } from "../controllers/connection-state.js";
import { base, panelBox, quietText } from "../elements/base/base-style.js";
import { renderGlance, renderStanding } from "./site-glance.js";
import { sitePath } from "../state/router.js";
import type { SiteSummary } from "../generated/api.js";
import "./thumbnail.js";

@customElement("t-fleet-card")
export class FleetCard extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: 7rem minmax(0, 1fr);
        align-items: start;
        gap: var(--t-space-3);
        padding: var(--t-space-3);
        ${panelBox}
      }
      :host([plain]) {
        grid-template-columns: minmax(0, 1fr);
      }
      .words {
        display: grid;
        gap: var(--t-space-1);
        min-inline-size: 0;
      }
      .head {
        display: flex;
        align-items: baseline;
        justify-content: space-between;
        gap: var(--t-space-2);
      }
      h3 {
        min-inline-size: 0;
        font-size: var(--t-size-m);
        overflow-wrap: anywhere;
      }
      h3 a {
        color: inherit;
        text-decoration: none;
      }
      h3 a:hover {
        text-decoration: underline;
      }
      .facts {
        ${quietText}
      }
      .bad {
        color: var(--t-bad);
        font-weight: var(--t-weight-strong);
      }
      .warn {
        color: var(--t-warn);
        font-weight: var(--t-weight-strong);
      }
    `,
  ];

  @property({ attribute: false }) row: SiteSummary | null = null;
  @property({ type: Number }) bad = 0;
  @property({ type: Number }) warn = 0;
  /** Without a picture. */
  @property({ type: Boolean, reflect: true }) plain = false;
  private readonly link = new ConnectionStateController(this);

  override render(): TemplateResult | typeof nothing {
    const { row } = this;
    if (row === null) return nothing;
    return html`${this.plain ? nothing : html`<t-thumbnail .site=${row.site} .stream=${row.stream} .online=${row.online} label=${msg(str`Live picture of ${row.name}`)}></t-thumbnail>`}
      <div class="words">
        <div class="head">
          <h3><a href=${sitePath(row.site, "live")}>${row.name}</a></h3>
          ${renderStanding(row, this.link.state)}
        </div>
        ${renderGlance(row, this)}
      </div>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-fleet-card": FleetCard;
  }
}
