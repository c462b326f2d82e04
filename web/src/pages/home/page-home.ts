/** Home: every site this person may see, with its health. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { RefreshController } from "../../controllers/refresh.js";
import { base, plainList } from "../../elements/base/base-style.js";
import { adviceFor } from "../../format/error-advice.js";
import { sessionContext, sitesContext } from "../../state/contexts.js";
import { seesOnlyPublic } from "../../state/rights.js";
import type { Sites } from "../../state/sites.js";
import type { Me } from "../../generated/api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/loading.js";
import "../../tiles/site-card.js";
import "./fleet-view.js";

/** More sites than these stand on small cards, which ask for nothing each. */
const MOST_LARGE = 8;
/** States, batteries and places are asked for anew (ms). */
const EVERY_MS = 5000;

@customElement("t-page-home")
export class PageHome extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-4);
      }
      .head {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        gap: var(--t-space-1) var(--t-space-4);
      }
      .sites {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(26rem, 100%), 1fr));
        gap: var(--t-space-4);
        ${plainList}
      }
      .alone {
        grid-template-columns: minmax(0, 1fr);
      }
      t-site-card {
        block-size: 100%;
      }
    `,
  ];

  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly link = new ConnectionStateController(this);
  protected readonly refresh = new RefreshController(this, EVERY_MS, () => {
    // A load that failed is asked for by its button.
    if (this.sites.store?.status === "ready") void this.sites.store.load();
  });

  override render(): TemplateResult | null {
    const sites = this.sites.store;
    if (sites === undefined) return null;
    return html`
      <div class="head">
        <h1>${msg("Sites")}</h1>
        ${sites.list.length === 0 || this.link.state === "lost" ? nothing : html`<p class="muted">${sitesSummary(sites)}</p>`}
        ${sites.list.some(({ latitude }) => latitude !== null) ? html`<a href="/map">${msg("Map of all robots")}</a>` : nothing}
        ${sites.list.length > 1 && mayOpenFleet(this.session.store?.person) ? html`<a href="/fleet">${msg("Commands and STOP for several")}</a>` : nothing}
      </div>
      ${this.renderProblem(sites)} ${this.renderContent(sites)}
    `;
  }

  private renderProblem(sites: Sites): unknown {
    if (sites.status !== "failed") return nothing;
    return renderAdvice(adviceFor(sites.renderError, msg("the list of sites")), this.retry);
  }

  private renderContent(sites: Sites): unknown {
    if (sites.list.length > 0) {
      if (sites.list.length > MOST_LARGE) return html`<t-fleet-view .rows=${sites.list}></t-fleet-view>`;
      const alone = sites.list.length === 1;
      return html`<ul class=${alone ? "sites alone" : "sites"}>
        ${repeat(
          sites.list,
          (row) => row.site,
          (row) => html`<li><t-site-card .row=${row} ?wide=${alone}></t-site-card></li>`,
        )}
      </ul>`;
    }
    switch (sites.status) {
      case "idle":
      case "loading":
        return html`<t-loading what=${msg("Loading your sites")}></t-loading>`;
      case "failed":
        return nothing;
      case "ready":
        return html`<t-empty heading=${msg("No sites yet")} icon="unlinked">
          <p>${msg("A site appears here once its gateway has connected to this hub, and you have the right to view it.")}</p>
        </t-empty>`;
    }
  }

  private readonly retry = (): void => {
    void this.sites.store?.load();
  };
}

function mayOpenFleet(person: Me | null | undefined): boolean {
  return person !== null && person !== undefined && person.role !== "display" && !seesOnlyPublic(person);
}

function sitesSummary(sites: Sites): string {
  const online = sites.list.filter((row) => row.online).length;
  return msg(str`${String(online)} of ${String(sites.list.length)} online`);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-home": PageHome;
  }
}
