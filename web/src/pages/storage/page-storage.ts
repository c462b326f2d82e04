/** How much room the history takes, signal by signal, and when there is none left. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { styled } from "../../elements/base/style-directive.js";
import { formatBytes } from "../../format/bytes.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import type { StorageShape } from "../../generated/api.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { signalUsage } from "./signal-usage.js";
import { storageStyle } from "./storage-style.js";
import { forecastText, warningOf } from "./storage-text.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/status.js";
import "../admin-tabs.js";
import "./storage-table.js";

@customElement("t-page-storage")
export class PageStorage extends LitElement {
  static override styles = [base, sheets, storageStyle];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly use = new LoadController<StorageShape>(this);

  override willUpdate(): void {
    this.use.load("storage", () => new AdminApi(this.api).storage());
  }

  override render(): TemplateResult {
    const use = this.use.value;
    return html`<t-admin-tabs page="storage"></t-admin-tabs>
      ${renderPageHead(
        msg("Storage"),
        nothing,
        html`<t-button ?hidden=${use === undefined} ?busy=${this.use.result.state === "loading"} @click=${this.use.invalidate}>${msg("Look again")}</t-button>`,
      )}
      ${renderLoaded(this.use, msg("what is stored"), (value) => this.renderContent(value))}`;
  }

  private renderContent(use: StorageShape): TemplateResult {
    const signals = signalUsage(use.channels);
    const zone = this.sites.store?.zone ?? "UTC";
    const warning = warningOf(use, zone);
    return html`<section class="sheet" aria-label=${msg("All of it")}>
        ${renderFacts(use)} ${use.free_bytes === null ? nothing : renderDiskBar(use, use.free_bytes)}
        <div class="forecast">
          ${warning === null || warning.kind === "info"
            ? nothing
            : html`<t-status kind=${warning.kind === "bad" ? "bad" : "warn"} word=${warning.kind === "bad" ? msg("Act now") : msg("Soon full")}></t-status>`}
          <p>${use.trouble === "" && use.files_trouble === "" ? forecastText(use, zone) : warning?.text}</p>
        </div>
      </section>
      ${signals.length === 0
        ? html`<t-empty heading=${msg("Too early to say")} icon="history"
            ><p>
              ${msg("Every sample that came is stored. How much room a signal takes is told here once some ten thousand samples of it have come.")}
            </p></t-empty
          >`
        : html`<t-storage-table .signals=${signals} .zoneOf=${this.zoneOf}></t-storage-table>`}
      <section class="sheet" aria-label=${msg("How to change it")}>
        <h2>${msg("How long it is kept")}</h2>
        <p>
          ${msg(html`For good, unless the site description at the gateway says otherwise: <code>keep: 30</code> at a signal keeps 30 days of it. It takes effect at once: the gateway follows its file while it runs.`)}
        </p>
        <p>
          ${use.limit_bytes === 0 ? msg(html`There is no limit for all signals together: <code>talaia hub --history-gb 50</code> sets one of 50 GB, and then the oldest go first. Nothing else ever drops a sample.`) : msg(html`All signals together may take ${formatBytes(use.limit_bytes)}: <code>talaia hub --history-gb 50</code> sets one of 50 GB, and then the oldest go first. Nothing else ever drops a sample.`)}
        </p>
      </section>`;
  }

  private readonly zoneOf = (site: string): string => this.sites.store?.zoneOf(site) ?? "UTC";
}

function renderFacts(use: StorageShape): TemplateResult {
  const rest = Math.max(0, use.database_bytes - use.blocks_bytes);
  return html`<dl>
    <div>
      <dt>${msg("Samples")}</dt>
      <dd class="large">${formatBytes(use.blocks_bytes)}</dd>
      <dd class="muted">${use.limit_bytes === 0 ? msg("no limit") : msg(str`of at most ${formatBytes(use.limit_bytes)}`)}</dd>
    </div>
    <div>
      <dt>${msg("Rollups, indices and the rest")}</dt>
      <dd class="large">${formatBytes(rest)}</dd>
      ${use.spare_bytes === 0 ? nothing : html`<dd class="muted">${msg(str`and ${formatBytes(use.spare_bytes)} free inside the file`)}</dd>`}
    </div>
    <div>
      <dt>${msg("Growth")}</dt>
      <dd class="large">${msg(str`${formatBytes(use.day_bytes)} a day`)}</dd>
      <dd class="muted">${msg("at the last week's rate")}</dd>
    </div>
    <div>
      <dt>${msg("Free on the disk")}</dt>
      ${use.free_bytes === null
        ? html`<dd class="muted">${msg("not known: it is the database server's")}</dd>`
        : html`<dd class="large">${formatBytes(use.free_bytes)}</dd>
            <dd class="muted">${msg(str`of ${formatBytes(use.disk_bytes)}`)}</dd>`}
    </div>
    <div>
      <dt>${msg("Database")}</dt>
      <dd>${use.kind}</dd>
      <dd class="muted">${use.place}</dd>
    </div>
  </dl>`;
}

/** The disk: the history's part, what else is on it, and what is free. */
function renderDiskBar(use: StorageShape, free: number): TemplateResult {
  const ours = use.database_bytes + use.spare_bytes;
  const others = Math.max(0, use.disk_bytes - free - ours);
  const part = (bytes: number): Readonly<Record<string, string>> => ({ "flex-basis": `${String((100 * bytes) / Math.max(1, use.disk_bytes))}%` });
  return html`<div>
    <div class="bar" role="img" aria-label=${msg(str`Of the disk ${formatBytes(ours)} are the database, ${formatBytes(others)} other things, ${formatBytes(free)} free`)}>
      <span class="ours" ${styled(part(ours))}></span><span class="others" ${styled(part(others))}></span>
    </div>
    <div class="key" aria-hidden="true">
      <span>${msg(str`the database ${formatBytes(ours)}`)}</span><span>${msg(str`other things ${formatBytes(others)}`)}</span><span>${msg(str`free ${formatBytes(free)}`)}</span>
    </div>
  </div>`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-storage": PageStorage;
  }
}
