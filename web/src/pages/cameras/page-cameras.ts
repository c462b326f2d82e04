/** All cameras of a site at once, each as large as there is room for. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { sessionContext, sitesContext } from "../../state/contexts.js";
import { isSiteAdmin } from "../../state/rights.js";
import { devicePath, sitePath, zonesPath } from "../../state/router.js";
import type { SiteShape } from "../../generated/api.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/feedback/empty.js";
import { showsExposures } from "../../tiles/observatory/roles.js";
import "../../tiles/camera/camera-tile.js";

@customElement("t-page-cameras")
export class PageCameras extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      .cameras {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(24rem, 100%), 1fr));
        gap: var(--t-space-4);
      }
      figure {
        display: grid;
        gap: var(--t-space-1);
        margin: 0;
        min-inline-size: 0;
      }
      figcaption {
        display: flex;
        flex-wrap: wrap;
        gap: 0 var(--t-space-3);
      }
      figcaption a {
        color: var(--t-muted);
      }
      .draw {
        margin-inline-start: auto;
      }
    `,
  ];

  @property() site = "";

  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly link = new ConnectionStateController(this);
  private readonly detail = new LoadController<SiteShape>(this);

  override willUpdate(): void {
    const sites = this.sites.store;
    if (sites === undefined || this.site === "") return;
    this.detail.load(`${this.site} ${sites.catalogueOf(this.site)}`, () => sites.loadDetail(this.site));
  }

  override render(): TemplateResult {
    return html`<div class="head">
        <h1>${msg("Cameras")}</h1>
        ${this.hasDetection() ? html`<div class="actions"><a href=${sitePath(this.site, "sightings")}>${msg("What they have seen")}</a></div>` : nothing}
      </div>
      ${renderLoaded(this.detail, msg("the cameras"), (detail) => this.renderContent(detail))}`;
  }

  private mayDraw(): boolean {
    return isSiteAdmin(this.session.store?.person, this.site);
  }

  /** Something is looked for on the pictures of one of them. */
  private hasDetection(): boolean {
    return this.detail.value?.devices.some(({ streams }) => streams.some(({ detect }) => detect != null)) === true;
  }

  private renderContent(detail: SiteShape): TemplateResult {
    const cameras = detail.devices.flatMap((device) => device.streams.map((stream) => ({ device, stream })));
    if (cameras.length === 0) {
      return html`<t-empty heading=${msg("No cameras")} icon="camera">
        <p>${msg("None of the devices that you may see has a stream in the site's description.")}</p>
      </t-empty>`;
    }
    const online = (this.sites.store?.siteRow(this.site)?.online ?? detail.online) && this.link.state === "open";
    return html`<div class="cameras">
      ${repeat(
        cameras,
        ({ stream }) => stream.address,
        ({ device, stream }) => html`<figure>
          <t-camera
            data-stream=${stream.address}
            .site=${this.site}
            .stream=${stream.address}
            .name=${stream.name}
            .detect=${stream.detect}
            .lane=${stream.lane}
            .models=${stream.models}
            ?blurred=${stream.blurred}
            ?unblurrable=${stream.may_unblur}
            .online=${online}
            ?still=${showsExposures(device)}
          ></t-camera>
          <figcaption>
            ${stream.name} ${device.name === stream.name ? nothing : html`<a href=${devicePath(this.site, device.id)}>${device.name}</a>`}
            ${device.drive?.ptz === true ? html`<a href=${sitePath(this.site, "drive")}>${msg("Pan, tilt, zoom")}</a>` : nothing}
            ${this.mayDraw() && !showsExposures(device) ? html`<a class="draw" href=${zonesPath(this.site, stream.address)}>${msg("Zones and lines")}</a>` : nothing}
          </figcaption>
        </figure>`,
      )}
    </div>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-cameras": PageCameras;
  }
}
