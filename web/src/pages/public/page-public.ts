/** All public data on one page: what a guest sees, and nothing that can be done. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { adviceFor } from "../../format/error-advice.js";
import { sitesContext } from "../../state/contexts.js";
import { devicePath } from "../../state/router.js";
import type { Sites } from "../../state/sites.js";
import type { SiteShape } from "../../generated/api.js";
import { publicOf, type PublicDevice } from "./public-parts.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/values/clock.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/loading.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";
import { showsExposures } from "../../tiles/observatory/roles.js";
import "../../tiles/camera/camera-tile.js";
import "../../tiles/signal-value.js";

@customElement("t-page-public")
export class PagePublic extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      .site {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        gap: var(--t-space-1) var(--t-space-4);
      }
      .devices {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(26rem, 100%), 1fr));
        gap: var(--t-space-4);
        align-items: start;
      }
      .values {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(10rem, 100%), 1fr));
        gap: var(--t-space-4);
      }
      /* What is public may be a sentence: it must not make the page wider than a phone. */
      section,
      .sheet {
        grid-template-columns: minmax(0, 1fr);
        min-inline-size: 0;
      }
      section {
        display: grid;
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
      h3 a {
        color: inherit;
        text-decoration: none;
      }
      h3 a:hover {
        text-decoration: underline;
      }
    `,
  ];

  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly link = new ConnectionStateController(this);
  private readonly details = new LoadController<readonly SiteShape[]>(this);

  override willUpdate(): void {
    const sites = this.sites.store;
    if (sites?.status !== "ready") return;
    const question = sites.list.map((row) => `${row.site} ${sites.catalogueOf(row.site)}`).join("\n");
    this.details.load(question, () => Promise.all(sites.list.map((row) => sites.loadDetail(row.site))));
  }

  override render(): TemplateResult | typeof nothing {
    const sites = this.sites.store;
    if (sites === undefined) return nothing;
    return html`<div class="head">
        <div>
          <h1>${msg("Public data")}</h1>
          <p class="muted">${msg("What everybody may see who signs in here.")}</p>
        </div>
      </div>
      ${this.renderProblem(sites)} ${this.renderContent(sites)}`;
  }

  private renderProblem(sites: Sites): unknown {
    const { result } = this.details;
    const error = sites.status === "failed" ? sites.renderError : result.state === "failed" ? result.error : null;
    if (error === null) return nothing;
    return renderAdvice(adviceFor(error, msg("the public data")), this.retry);
  }

  private renderContent(sites: Sites): unknown {
    const details = this.details.value;
    if (details === undefined) {
      const failed = sites.status === "failed" || this.details.result.state === "failed";
      return failed ? nothing : html`<t-loading what=${msg("Loading the public data")}></t-loading>`;
    }
    const shown = details
      .map((detail) => ({ detail, devices: publicOf(detail) }))
      .filter(({ devices }) => devices.length > 0);
    if (shown.length === 0) {
      return html`<t-empty heading=${msg("Nothing is public yet")} icon="open">
        <p>${msg(html`What a site's description marks with <code>visibility: public</code> stands here for everybody.`)}</p>
      </t-empty>`;
    }
    return repeat(
      shown,
      ({ detail }) => detail.site,
      ({ detail, devices }) => this.renderSiteView(detail, devices, sites),
    );
  }

  private renderSiteView(detail: SiteShape, devices: readonly PublicDevice[], sites: Sites): TemplateResult {
    const row = sites.siteRow(detail.site);
    const online = (row?.online ?? detail.online) && this.link.state === "open";
    return html`<section aria-labelledby=${`site-${detail.site}`}>
      <div class="site">
        <h2 id=${`site-${detail.site}`}>${row?.name ?? detail.name}</h2>
        <t-status kind=${online ? "online" : "offline"}></t-status>
        <t-clock zone=${detail.zone}></t-clock>
        ${online
          ? nothing
          : html`<span class="muted"
              >${msg(html`last heard of <t-time .us=${row?.last_seen_us ?? detail.last_seen_us} .zone=${detail.zone}></t-time
            >`)}</span>`}
      </div>
      <div class="devices">
        ${repeat(
          devices,
          ({ device }) => device.id,
          (device) => this.renderDeviceView(detail.site, device, online),
        )}
      </div>
    </section>`;
  }

  private renderDeviceView(site: string, { device, signals, streams }: PublicDevice, online: boolean): TemplateResult {
    return html`<div class="sheet">
      <h3><a href=${devicePath(site, device.id)}>${device.name}</a></h3>
      ${repeat(
        streams,
        (stream) => stream.address,
        (stream) => html`<t-camera
          .site=${site}
          .stream=${stream.address}
          .name=${stream.name}
          .detect=${stream.detect}
          .lane=${stream.lane}
          .models=${stream.models}
          ?blurred=${stream.blurred}
          ?unblurrable=${stream.may_unblur}
          .online=${online}
          ?still=${showsExposures(device)}
        ></t-camera>`,
      )}
      ${signals.length === 0
        ? nothing
        : html`<div class="values">
            ${repeat(
              signals,
              (signal) => signal.address,
              (signal) => html`<t-signal-value size="l" .site=${site} .signal=${signal}></t-signal-value>`,
            )}
          </div>`}
      ${signals.length + streams.length === 0 ? html`<p class="muted">${msg("It is there; its values are not public.")}</p>` : nothing}
    </div>`;
  }

  private readonly retry = (): void => {
    void this.sites.store?.load();
    this.details.invalidate();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-public": PagePublic;
  }
}
