/** Gateways: which are there, how they stand, and how another one comes in. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { TickerController } from "../../controllers/ticker.js";
import { base } from "../../elements/base/base-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { renderRows } from "../../elements/layout/rows.js";
import { formatDuration } from "../../format/duration.js";
import { plural } from "../../words/plural.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import type { DeviceSummary, GatewayList, GatewayShape, HubList, OpenCodeShape, ReleaseList } from "../../generated/api.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/empty.js";
import "../admin-tabs.js";
import "./enrol-form.js";
import "./gateway-section.js";
import "./hub-list.js";
import "./release-list.js";

/** A gateway that comes or goes is seen this soon (s). */
const AGAIN_S = 3;

interface LoadedGateways extends GatewayList {
  readonly devices: readonly DeviceSummary[];
  readonly hubs: HubList;
  readonly releases: ReleaseList;
}

@customElement("t-page-gateways")
export class PageGateways extends LitElement {
  static override styles = [base, sheets];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly known = new LoadController<LoadedGateways>(this);
  private readonly action = new ActionController(this);
  private readonly form = new OpenSubject<"new">(this);

  constructor() {
    super();
    new TickerController(this);
  }

  override willUpdate(): void {
    const turn = Math.floor(Date.now() / (AGAIN_S * 1000));
    this.known.load(String(turn), async () => {
      const admin = new AdminApi(this.api);
      const [list, devices, hubs, releases] = await Promise.all([admin.gateways(), this.api.devices(), admin.hubs(), admin.releases()]);
      return { ...list, devices, hubs, releases };
    });
  }

  override render(): TemplateResult {
    const known = this.known.value;
    return html`<t-admin-tabs page="gateways"></t-admin-tabs>
      ${renderPageHead(
        msg("Gateways"),
        msg("Each runs beside its robots, connects to this hub, and has its own key."),
        html`<t-button kind="primary" ?hidden=${this.form.isOpen} @click=${this.form.opener("new")}>${msg("Enrol a gateway")}</t-button>`,
      )}
      ${this.form.isOpen
        ? html`<t-enrol
            class="sheet"
            .sites=${known === undefined ? [] : [...new Set(known.gateways.map(({ site }) => site))]}
            .gateways=${known?.gateways ?? []}
            .zone=${this.sites.store?.zone ?? "UTC"}
            @t-close=${this.form.close}
            @t-changed=${this.known.invalidate}
          ></t-enrol>`
        : nothing}
      ${renderAdvice(this.action.problem)} ${renderLoaded(this.known, msg("the list of gateways"), (value) => this.renderContent(value))}`;
  }

  private renderContent(known: LoadedGateways): TemplateResult {
    const living = known.gateways.filter((row) => row.revoked_us === 0);
    const gone = known.gateways.filter((row) => row.revoked_us > 0);
    return html`<t-hub-list ?hidden=${!known.hubs.clustered} .list=${known.hubs}></t-hub-list>
      ${this.renderCodes(known.codes)}
      ${living.length === 0
        ? html`<t-empty heading=${msg("No gateway yet")} icon="unlinked">
            <p>${msg("Enrol one: you get a command to run beside the robot, with a code that works once.")}</p>
          </t-empty>`
        : nothing}
      ${this.renderList(living, known.devices)}
      <t-release-list
        ?hidden=${known.releases.gateways.length === 0 && known.releases.releases.length === 0}
        .list=${known.releases}
        .siteNames=${this.siteName}
        .zone=${this.sites.store?.zone ?? "UTC"}
        @t-changed=${this.known.invalidate}
      ></t-release-list>
      ${gone.length === 0
        ? nothing
        : html`<details>
            <summary>${plural(gone.length, msg("1 gateway was revoked"), msg(str`${String(gone.length)} gateways were revoked`))}</summary>
            ${this.renderList(gone, [])}
          </details>`}`;
  }

  private readonly siteName = (site: string): string => this.sites.store?.siteRow(site)?.name ?? site;

  private renderList(rows: readonly GatewayShape[], devices: readonly DeviceSummary[]): unknown {
    return repeat(
      rows,
      (row) => row.id,
      (row) => html`<t-gateway-sheet
        class="sheet"
        .row=${row}
        .devices=${devices.filter(({ site }) => site === row.site)}
        .siteName=${this.siteName(row.site)}
        .zone=${this.sites.store?.zoneOf(row.site) ?? "UTC"}
        @t-changed=${this.known.invalidate}
      ></t-gateway-sheet>`,
    );
  }

  private renderCodes(codes: readonly OpenCodeShape[]): unknown {
    const now = Date.now() * 1000;
    const good = codes.filter((row) => row.expires_us > now);
    if (good.length === 0) return nothing;
    return html`<section class="sheet" aria-label=${msg("Codes that are not used yet")}>
      <h2>${msg("Codes that are not used yet")}</h2>
      ${renderRows(
        good,
        (row) => html`<li>
          <div>
            <span class="name">${row.site}</span>
            <div class="facts"><span>${msg(str`good for ${formatDuration((row.expires_us - now) / 1e6)} more`)}</span></div>
          </div>
          <t-button label=${msg(str`Withdraw the code for ${row.site}`)} ?busy=${this.action.runningKey === row.id} @click=${this.codeWithdrawer(row)}>${msg("Withdraw")}</t-button>
        </li>`,
      )}
    </section>`;
  }

  private codeWithdrawer(row: OpenCodeShape): () => void {
    return () => {
      const api = new AdminApi(this.api);
      void this.action.run(msg("withdraw the code"), () => api.withdrawCode(row.id), "", row.id).then(this.known.invalidate);
    };
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-gateways": PageGateways;
  }
}
