import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { LoadController } from "../controllers/load.js";
import { ConnectionStateController } from "../controllers/connection-state.js";
import { ContextStoreController } from "../controllers/context-store.js";
import { TickerController } from "../controllers/ticker.js";
import { base, quietText } from "../elements/base/base-style.js";
import { formatDuration } from "../format/duration.js";
import { plural } from "../words/plural.js";
import { alarmsContext, sitesContext } from "../state/contexts.js";
import { sitePath } from "../state/router.js";
import type { SignalShape, SiteShape, SiteSummary } from "../generated/api.js";
import "../elements/layout/card.js";
import "../elements/base/icon.js";
import "../elements/values/time.js";
import { firstPageOf, firstPageSignals } from "./catalog.js";
import "./observatory/device-summary.js";
import "./signal-value.js";
import { renderGlance, renderStanding } from "./site-glance.js";
import { troubleAt } from "./site-trouble.js";
import "./thumbnail.js";

const SHOWN = 4;
const SHOWN_EACH = 6;

/** One site: whether it is there, what it says, and the ways into it. */
@customElement("t-site-card")
export class SiteCard extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
      }
      t-card {
        display: grid;
        grid-template-rows: auto 1fr auto;
        gap: var(--t-space-4);
        block-size: 100%;
        padding: 0;
        overflow: hidden;
      }
      header {
        display: grid;
        gap: var(--t-space-1);
        padding: var(--t-space-4) var(--t-space-4) 0;
      }
      /* The picture stands beside the words, above the values. */
      header:has(t-thumbnail) {
        grid-template-columns: minmax(0, 1fr) minmax(7rem, 26%);
        align-items: start;
        column-gap: var(--t-space-3);
      }
      .words {
        display: grid;
        gap: var(--t-space-1);
        min-inline-size: 0;
      }
      .head {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        justify-content: space-between;
        gap: var(--t-space-1) var(--t-space-3);
      }
      h2 a {
        color: inherit;
        text-decoration: none;
      }
      h2 a:hover {
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
      .values {
        display: grid;
        grid-template-columns: repeat(2, minmax(0, 1fr));
        gap: var(--t-space-4);
        padding-inline: var(--t-space-4);
        min-block-size: 4.25rem;
      }
      .note {
        grid-column: 1 / -1;
      }
      /* Alone on the page, with room for every device. */
      :host([wide]) {
        header {
          padding: var(--t-space-5) var(--t-space-5) 0;
        }
        h2 {
          font-size: var(--t-size-xl);
        }
        .values {
          grid-template-columns: repeat(auto-fit, minmax(min(18rem, 100%), 1fr));
          gap: var(--t-space-5);
          padding: var(--t-space-2) var(--t-space-5);
        }
        nav a {
          min-block-size: 3.5rem;
          font-size: var(--t-size-m);
        }
      }
      section {
        display: grid;
        align-content: start;
        gap: var(--t-space-3);
        padding-block-start: var(--t-space-3);
        border-block-start: 2px solid var(--t-line);
      }
      h3 {
        color: var(--t-muted);
      }
      t-telling {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(11.5rem, 1fr));
        gap: var(--t-space-4) var(--t-space-3);
        --t-size-xxl: 2.375rem;
      }
      @media (max-width: 60rem) {
        t-telling {
          grid-template-columns: repeat(auto-fill, minmax(8.5rem, 1fr));
          --t-size-xxl: var(--t-size-xl);
        }
      }
      nav {
        display: flex;
        border-block-start: 1px solid var(--t-line);
      }
      nav a {
        flex: 1;
        display: flex;
        align-items: center;
        justify-content: center;
        gap: var(--t-space-2);
        min-block-size: var(--t-touch);
        padding-inline: var(--t-space-2);
        font-size: var(--t-size-s);
        font-weight: var(--t-weight-strong);
        text-decoration: none;
      }
      nav a + a {
        border-inline-start: 1px solid var(--t-line);
      }
      nav a:hover {
        background: var(--t-raised);
      }
      a:focus-visible {
        outline-offset: -3px;
      }
    `,
  ];

  @property({ attribute: false }) row: SiteSummary | null = null;
  /** It is the only one and has the page to itself: values by device. */
  @property({ type: Boolean, reflect: true }) wide = false;

  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly alarms = new ContextStoreController(this, alarmsContext);
  private readonly link = new ConnectionStateController(this);
  private readonly detail = new LoadController<SiteShape>(this);

  constructor() {
    super();
    new TickerController(this);
  }

  override willUpdate(): void {
    const row = this.row;
    const sites = this.sites.store;
    if (row === null || sites === undefined) return;
    this.detail.load(`${row.site} ${sites.catalogueOf(row.site)}`, () => sites.loadDetail(row.site));
  }

  override render(): TemplateResult | null {
    const row = this.row;
    if (row === null) return null;
    const since = formatDuration(Date.now() / 1000 - row.since_us / 1e6);
    return html`<t-card>
      <header>
        <div class="words">
          <div class="head">
            <h2><a href=${sitePath(row.site, "live")}>${row.name}</a></h2>
            ${renderStanding(row, this.link.state)}
          </div>
          <p class="facts">
            ${plural(row.devices, msg("1 device"), msg(str`${String(row.devices)} devices`))}, ${plural(row.signals, msg("1 signal"), msg(str`${String(row.signals)} signals`))}${staleness(row)} ·
            ${this.link.state === "lost"
              ? msg("connection lost")
              : row.online
                ? html`${msg(str`online for ${since}`)}`
                : msg(html`last heard of <t-time .us=${row.last_seen_us} .zone=${row.zone}></t-time>`)}
          </p>
          ${row.online ? renderGlance(row, troubleAt(this.alarms.store, row.site)) : nothing}
        </div>
        ${row.stream === "" ? nothing : html`<t-thumbnail .site=${row.site} .stream=${row.stream} .online=${row.online} label=${msg(str`Live picture of ${row.name}`)}></t-thumbnail>`}
      </header>
      <div class="values">${this.renderValues(row)}</div>
      <nav aria-label=${row.name}>
        <a href=${sitePath(row.site, "live")}><t-icon name="live"></t-icon>${msg("Real-time")}</a>
        <a href=${sitePath(row.site, "history")}><t-icon name="history"></t-icon>${msg("History")}</a>
        ${this.isUsable()
          ? html`<a href=${sitePath(row.site, "drive")}><t-icon name="drive"></t-icon>${msg("Actuate")}</a>`
          : nothing}
      </nav>
    </t-card>`;
  }

  private renderValues(row: SiteSummary): unknown {
    if (this.detail.result.state === "failed") {
      return html`<p class="facts note">${msg("Its description could not be loaded. It is asked for again when the site changes.")}</p>`;
    }
    if (this.wide) return this.renderByDevice(row);
    const signals = firstPageOf(this.detail.value?.devices ?? [], SHOWN);
    if (this.detail.value !== undefined && signals.length === 0) {
      return this.renderNoValues();
    }
    return repeat(
      signals,
      (signal) => signal.address,
      (signal) =>
        html`<t-signal-value
          size="l"
          .site=${row.site}
          .signal=${signal}
          .label=${this.label(signal, signals)}
        ></t-signal-value>`,
    );
  }

  /** Two devices may both have a "State": then it is said whose. */
  private label(signal: SignalShape, shown: readonly SignalShape[]): string {
    if (shown.filter((candidate) => candidate.name === signal.name).length < 2) return "";
    const owner = this.detail.value?.devices.find((device) => device.signals.includes(signal));
    return owner === undefined ? "" : `${owner.name}: ${signal.name}`;
  }

  private renderByDevice(row: SiteSummary): unknown {
    const detail = this.detail.value;
    if (detail === undefined) return nothing;
    const devices = detail.devices.filter((device) => firstPageSignals(device, 1).length > 0);
    if (devices.length === 0) return this.renderNoValues();
    return repeat(
      devices,
      ({ id }) => id,
      (device) => html`<section>
        <h3>${device.name}</h3>
        <t-telling
          size="xl"
          .site=${row.site}
          .device=${device}
          .detail=${detail}
          .online=${row.online}
          .signals=${firstPageSignals(device, SHOWN_EACH)}
        ></t-telling>
      </section>`,
    );
  }

  private renderNoValues(): TemplateResult {
    return html`<p class="facts note">${msg("No values to show here: none is marked as primary, or none is yours to see.")}</p>`;
  }

  private isUsable(): boolean {
    return (this.detail.value?.devices ?? []).some(
      (device) => device.rights.includes("use") && (device.drive !== null || device.commands.length > 0),
    );
  }
}

function staleness(row: SiteSummary): string {
  return row.online && row.stale > 0 ? msg(str`, ${String(row.stale)} of them stale`) : "";
}

declare global {
  interface HTMLElementTagNameMap {
    "t-site-card": SiteCard;
  }
}
