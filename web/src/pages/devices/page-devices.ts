/** Every device that is open to the person, with how it stands. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { TickerController } from "../../controllers/ticker.js";
import { base, plainList, raisedBox } from "../../elements/base/base-style.js";
import type { ChoiceOption } from "../../elements/forms/choice.js";
import { control } from "../../elements/forms/input-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { plural } from "../../words/plural.js";
import { apiContext, reachContext, sitesContext } from "../../state/contexts.js";
import { devicePath } from "../../state/router.js";
import type { DeviceSummary, SiteShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { matchesSearch, deviceStatus, STANDING_WORDS, type DeviceStatus } from "./device-status.js";
import { deviceKindWords } from "../../format/kinds/device-kinds.js";
import { togetherText } from "../../words/lists.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/forms/choice.js";
import "../../elements/feedback/empty.js";
import "../../elements/base/icon.js";
import "../../elements/feedback/status.js";
import "../../tiles/observatory/device-summary.js";

/** Counts of stale signals are asked for again this often (s). */
const AGAIN_S = 5;

const STANDINGS: readonly ChoiceOption[] = [
  { id: "", label: msg("All", { id: "all.devices" }) },
  { id: "online", label: msg("Online") },
  { id: "stale", label: msg("Stale") },
  { id: "unreached", label: msg("Not reached") },
  { id: "offline", label: msg("Offline") },
];

@customElement("t-page-devices")
export class PageDevices extends LitElement {
  static override styles = [
    base,
    sheets,
    control,
    css`
      .tools {
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-2);
      }
      input {
        flex: 1 1 10rem;
      }
      section {
        display: grid;
        gap: var(--t-space-3);
      }
      ul {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(24rem, 100%), 1fr));
        gap: var(--t-space-3);
        ${plainList}
      }
      .device {
        display: grid;
        gap: var(--t-space-2);
        block-size: 100%;
        align-content: start;
        padding: var(--t-space-4);
        ${raisedBox}
        color: var(--t-text);
        text-decoration: none;
      }
      .device:hover {
        border-color: var(--t-edge);
      }
      .top {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        justify-content: space-between;
        gap: var(--t-space-1) var(--t-space-3);
      }
      .chips {
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-1);
      }
    `,
  ];

  @state() private words = "";
  @state() private chosen: DeviceStatus | "" = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly reach = new ContextStoreController(this, reachContext);
  private readonly rows = new LoadController<readonly DeviceSummary[]>(this);

  private readonly details = new LoadController<readonly SiteShape[]>(this);

  constructor() {
    super();
    new TickerController(this);
  }

  override willUpdate(): void {
    // Sites that come or go are told of by the connection; the rest is asked for now and then.
    const online = (this.sites.store?.list ?? []).map((row) => `${row.site} ${String(row.online)}`).join();
    const turn = Math.floor(Date.now() / (AGAIN_S * 1000));
    this.rows.load(`${online} ${String(turn)}`, () => this.api.devices());
    const sites = this.sites.store;
    const names = [...new Set((this.rows.value ?? []).map(({ site }) => site))];
    if (sites === undefined || names.length === 0) return;
    const question = names.map((site) => `${site} ${sites.catalogueOf(site)}`).join("\n");
    this.details.load(question, async () => {
      const found = await Promise.allSettled(names.map((site) => sites.loadDetail(site)));
      return found.flatMap((result) => (result.status === "fulfilled" ? [result.value] : []));
    });
  }

  override render(): TemplateResult {
    const rows = this.rows.value;
    return html`${renderPageHead(
        msg("Devices"),
        rows === undefined ? nothing : devicesSummary(rows),
        html`<div class="tools" role="search">
          <t-choice label=${msg("Status")} .options=${STANDINGS} .chosen=${this.chosen} @t-choose=${this.onChoose}></t-choice>
          <input type="search" aria-label=${msg("Filter devices")} placeholder=${msg("Filter", { id: "filter.verb" })} .value=${this.words} @input=${this.onInput} />
        </div>`,
      )}
      ${renderLoaded(this.rows, msg("the list of devices"), (loaded) => this.renderContent(loaded))}`;
  }

  private renderContent(rows: readonly DeviceSummary[]): unknown {
    if (rows.length === 0) {
      return html`<t-empty heading=${msg("You have no devices")} icon="devices">
        <p>${msg("A device appears here once its gateway has connected, and it is public or your role may view it.")}</p>
      </t-empty>`;
    }
    const shown = rows.filter((row) => matchesSearch(row, this.words, this.chosen, this.isUnreachable(row)));
    if (shown.length === 0) {
      return html`<t-empty heading=${msg("No device matches")} icon="devices">
        <p>${plural(rows.length, msg("One device is open to you, and it is not like this."), msg(str`${String(rows.length)} devices are open to you, and none of them is like this.`))}</p>
        <t-button @click=${this.clearSearch}>${msg("Show all")}</t-button>
      </t-empty>`;
    }
    const sites = new Map(shown.map((row) => [row.site, row.site_name]));
    return [...sites].map(
      ([site, name]) => html`<section aria-labelledby=${`site-${site}`}>
        <h2 id=${`site-${site}`}>${name}</h2>
        ${this.renderUnguarded(site)}
        <ul>
          ${repeat(
            shown.filter((row) => row.site === site),
            (row) => row.device,
            (row) => html`<li>${this.renderCard(row)}</li>`,
          )}
        </ul>
      </section>`,
    );
  }

  /** Domes and telescopes that do not close or park by themselves, said once for their site. */
  private renderUnguarded(site: string): unknown {
    const detail = this.details.value?.find((detail) => detail.site === site);
    const names = detail?.devices.filter((device) => device.unguarded).map((device) => device.name) ?? [];
    if (names.length === 0) return nothing;
    const many = names.length > 1;
    const who = togetherText(names);
    return html`<p class="unguarded" role="note">
      <t-icon name="info"></t-icon>
      <span>
        ${many ? msg(html`${who} do not close or park by themselves. In rain, in wind or without weather data only a person closes or parks them (docs: <em>Make a robot safe by itself</em>).`) : msg(html`${who} does not close or park by itself. In rain, in wind or without weather data only a person closes or parks it (docs: <em>Make a robot safe by itself</em>).`)}
      </span>
    </p>`;
  }

  private isUnreachable(row: DeviceSummary): boolean {
    return this.reach.store?.unreachableSince(row.site, row.device) !== undefined;
  }

  private renderCard(row: DeviceSummary): TemplateResult {
    const how = deviceStatus(row, this.isUnreachable(row));
    return html`<a class="device" href=${devicePath(row.site, row.device)}>
      <div class="top">
        <h3>${row.name}</h3>
        <t-status kind=${how === "unreached" ? "unknown" : how} word=${STANDING_WORDS[how](row)}></t-status>
      </div>
      ${this.renderSummary(row)}
      <div class="facts">
        <span>${deviceKindWords(row.kind)}</span>
        <span>${plural(row.signals, msg("1 signal"), msg(str`${String(row.signals)} signals`))}</span>
      </div>
      <div class="chips">
        ${row.rights.length === 0 ? nothing : html`<span class="chip">${msg("you:")} ${row.rights.at(-1)}</span>`}
        ${row.public ? html`<span class="chip">${msg("public")}</span>` : nothing}
      </div>
    </a>`;
  }

  /** The values themselves stand in the site's description; without that, the counts have to do. */
  private renderSummary(row: DeviceSummary): unknown {
    const detail = this.details.value?.find(({ site }) => site === row.site);
    const device = detail?.devices.find(({ id }) => id === row.device);
    if (detail === undefined || device === undefined) return nothing;
    return html`<t-telling .site=${row.site} .device=${device} .detail=${detail} .online=${row.online && !this.isUnreachable(row)}></t-telling>`;
  }

  private readonly onChoose = (event: CustomEvent<string>): void => {
    this.chosen = event.detail as DeviceStatus | "";
  };

  private readonly onInput = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.words = event.target.value;
  };

  private readonly clearSearch = (): void => {
    this.words = "";
    this.chosen = "";
  };
}

function devicesSummary(rows: readonly DeviceSummary[]): string {
  const online = rows.filter((row) => row.online).length;
  return msg(str`${String(online)} of ${String(rows.length)} online`);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-devices": PageDevices;
  }
}
