/** All robots of the fleet on one map, and for an admin: which maps may be shown. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, queryAll } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { RefreshController } from "../../controllers/refresh.js";
import { base, plainList } from "../../elements/base/base-style.js";
import { placeText } from "../../tiles/site-glance.js";
import { troublesOf } from "../../tiles/site-trouble.js";
import { drawnZones } from "../../tiles/map/site-overlays.js";
import type { SiteShape } from "../../generated/api.js";
import { alarmsContext, apiContext, interlocksContext, sessionContext, sitesContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import type { HubApi } from "../../wire/hub-api.js";
import { fleetRobots } from "./fleet-robots.js";
import "../../elements/map/geo-map.js";
import "./map-sources.js";

/** Places are asked for anew (ms). */
const EVERY_MS = 2000;
/** Zones of so many sites are drawn: each takes a description. */
const MOST_ZONED = 30;

@customElement("t-page-map")
export class PageMap extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-4);
      }
      t-geo-map {
        --t-map-height: max(22rem, calc(100dvh - 16rem));
      }
      ul {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(20rem, 100%), 1fr));
        gap: var(--t-space-1) var(--t-space-4);
        ${plainList}
      }
      li {
        display: flex;
        flex-wrap: wrap;
        gap: 0 var(--t-space-2);
      }
    `,
  ];

  @queryAll("li a") private readonly links!: NodeListOf<HTMLAnchorElement>;
  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly alarms = new ContextStoreController(this, alarmsContext);
  private readonly interlocks = new ContextStoreController(this, interlocksContext);
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly details = new LoadController<readonly SiteShape[]>(this);
  protected readonly refresh = new RefreshController(this, EVERY_MS, () => {
    if (this.sites.store?.status === "ready") void this.sites.store.load();
  });

  override willUpdate(): void {
    const sites = this.sites.store;
    if (sites === undefined) return;
    const zoned = sites.list.slice(0, MOST_ZONED).map(({ site }) => site);
    this.details.load(zoned.map((site) => `${site} ${sites.catalogueOf(site)}`).join("\n"), async () => {
      const found = await Promise.allSettled(zoned.map((site) => sites.loadDetail(site)));
      return found.flatMap((settled) => (settled.status === "fulfilled" ? [settled.value] : []));
    });
  }

  override render(): TemplateResult | typeof nothing {
    const sites = this.sites.store;
    if (sites === undefined) return nothing;
    const only = new URLSearchParams(location.search).get("site") ?? "";
    const rows = only === "" ? sites.list : sites.list.filter(({ site }) => site === only);
    const robots = fleetRobots(rows, troublesOf(this.alarms.store));
    const zones = (this.details.value ?? []).flatMap(({ site, map: drawn }) => drawnZones(site, drawn?.zones ?? [], this.alarms.store, this.interlocks.store));
    return html`
      <h1>${msg("Map")}</h1>
      <t-geo-map
        fleet
        .robots=${robots}
        .zones=${zones}
        note=${sites.status === "ready" ? msg("No site says where it is") : msg("Waiting for the sites")}
        @robot-chosen=${this.onRobot}
      ></t-geo-map>
      ${only === "" ? nothing : html`<p><a href="/map">${msg("Show all robots")}</a></p>`}
      <section aria-label=${msg("Robots on the map")}>
        <ul>
          ${map(
            rows,
            (row) => html`<li>
              <a href=${sitePath(row.site, "live")}>${row.name}</a>
              <span class="muted"
                >${row.latitude === null || row.longitude === null
                  ? msg("place not known")
                  : row.moving ? placeText(row.latitude, row.longitude) : row.online ? msg(str`${placeText(row.latitude, row.longitude)}, place of the site`) : msg(str`${placeText(row.latitude, row.longitude)}, offline`)}</span
              >
            </li>`,
          )}
        </ul>
      </section>
      ${this.session.store?.person?.admin === true ? html`<t-map-sources .api=${this.api}></t-map-sources>` : nothing}
    `;
  }

  private readonly onRobot = (event: CustomEvent<string>): void => {
    const chosen = [...this.links].find((link) => link.getAttribute("href") === sitePath(event.detail, "live"));
    chosen?.click();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-map": PageMap;
  }
}
