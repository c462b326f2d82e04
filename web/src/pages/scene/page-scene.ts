/** A site's robot in space. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import type { SiteShape } from "../../generated/api.js";
import { sitesContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import "../../tiles/scene/scene-tile.js";

@customElement("t-page-scene")
export class PageScene extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      :host {
        min-inline-size: 0;
      }
    `,
  ];

  @property() site = "";

  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly link = new ConnectionStateController(this);
  private readonly detail = new LoadController<SiteShape>(this);

  protected override willUpdate(): void {
    const sites = this.sites.store;
    if (sites === undefined || this.site === "") return;
    this.detail.load(`${this.site} ${sites.catalogueOf(this.site)}`, () => sites.loadDetail(this.site));
  }

  override render(): TemplateResult {
    const row = this.sites.store?.siteRow(this.site);
    const online = row?.online === true && this.link.state === "open";
    return html`${renderPageHead(
        msg("Scene"),
        msg(str`The robot of ${row?.name ?? this.site} in space, as its topics tell. It is heard for this only while you look.`),
        html`<div class="actions"><a href=${sitePath(this.site, "topics")}>${msg("Topics")}</a></div>`,
      )}
      ${renderLoaded(this.detail, msg("the site"), (detail) => html`<t-scene-tile .site=${this.site} .detail=${detail} .online=${online}></t-scene-tile>`)}`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-scene": PageScene;
  }
}
