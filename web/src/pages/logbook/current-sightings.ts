/** What the cameras of a site have in sight now: it has no line in the logbook before it is over. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import type { SeenShape, SiteShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { sightingPicturePath, SightingsApi } from "../../wire/sightings-api.js";
import { historyQuery } from "../sightings/sightings-query.js";
import "../../elements/analysis/sighting-card.js";

const MOST = 10;
/** What is told is in the hub's list this soon afterwards (ms). */
const SOON_MS = 300;

@customElement("t-in-sight")
export class CurrentSightings extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      :host {
        display: contents;
      }
      .more {
        color: var(--t-muted);
      }
    `,
  ];

  @property() site = "";
  @property() zone = "UTC";

  @state() private rows: readonly SeenShape[] = [];
  @state() private more = false;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly detail = new LoadController<SiteShape>(this);
  private asked: string | null = null;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor() {
    super();
    new ConnectionStateController(this, (connection) => [
      connection.onMessage("sighting", (news) => {
        if (news.site !== this.site) return;
        clearTimeout(this.timer);
        this.timer = setTimeout(() => void this.loadSightings(), SOON_MS);
      }),
    ]);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearTimeout(this.timer);
  }

  override willUpdate(): void {
    const sites = this.sites.store;
    if (sites !== undefined) this.detail.load(`${this.site} ${sites.catalogueOf(this.site)}`, () => sites.loadDetail(this.site));
    if (this.asked === this.site) return;
    this.asked = this.site;
    this.rows = [];
    void this.loadSightings();
  }

  override render(): TemplateResult | typeof nothing {
    if (this.rows.length === 0) return nothing;
    return html`<section class="sheet" aria-labelledby="in-sight">
      <h2 id="in-sight">${msg("In sight now")}</h2>
      <ul class="rows">
        ${repeat(
          this.rows,
          ({ id }) => id,
          (row) =>
            html`<li>
              <t-sighting
                .sighting=${row}
                .camera=${this.nameOf(row.camera)}
                .picture=${row.picture ? sightingPicturePath(this.site, row.id) : ""}
                .zone=${this.zone}
              >
                <div class="ways">
                  <a href=${`${sitePath(this.site, "history")}?${historyQuery(row, this.detail.value)}`} aria-label=${msg(str`Chart at the moment of ${row.label}`)}>${msg("Chart")}</a>
                </div>
              </t-sighting>
            </li>`,
        )}
      </ul>
      ${this.more ? html`<p class="ways more"><span>${msg("And more:")} <a href=${`${sitePath(this.site, "sightings")}?open=true`}>${msg("all that is in sight")}</a></span></p>` : nothing}
    </section>`;
  }

  private nameOf(camera: string): string {
    const streams = (this.detail.value?.devices ?? []).flatMap((device) => device.streams);
    return streams.find(({ address }) => address === camera)?.name ?? camera;
  }

  private async loadSightings(): Promise<void> {
    const { site } = this;
    try {
      const found = await new SightingsApi(this.api, site).findSightings(`open=true&limit=${String(MOST)}`);
      if (site !== this.site) return;
      this.rows = found.sightings;
      this.more = found.more;
    } catch {
      // The logbook below says what is wrong; the next news tries again.
    }
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-in-sight": CurrentSightings;
  }
}
