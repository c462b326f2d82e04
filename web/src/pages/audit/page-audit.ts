/** The audit log: who did what, and whether the chain of its rows holds. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { eventWords } from "../../format/kinds/event-kinds.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { renderTable, tables, type TableColumn } from "../../elements/layout/data-table.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { plural } from "../../words/plural.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { withQuery } from "../../state/router.js";
import type { AuditChain, AuditList, AuditRow } from "../../generated/api.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { auditStyle } from "./audit-style.js";
import { NO_FILTER, auditPageQuery, readAuditFilter, writeAuditFilter, type AuditFilter } from "./audit-query.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/problem.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";
import "../admin-tabs.js";
import "./audit-filter.js";
import "./witnessed-hubs.js";

const ROWS = 50;

@customElement("t-page-audit")
export class PageAudit extends LitElement {
  static override styles = [base, sheets, tables, auditStyle];

  /** The last row of each page before this one. */
  @state() private trail: readonly string[] = [];
  @state() private check: AuditChain | null = null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly page = new LoadController<AuditList>(this);
  private readonly action = new ActionController(this);
  private shown = "";

  override willUpdate(): void {
    const filter = this.filter();
    const written = writeAuditFilter(filter);
    if (written !== this.shown) {
      this.shown = written;
      this.trail = [];
    }
    const query = auditPageQuery(filter, this.trail.at(-1) ?? "", ROWS);
    this.page.load(query, () => new AdminApi(this.api).audit(query));
  }

  override render(): TemplateResult {
    const filter = this.filter();
    const zone = this.sites.store?.zone ?? "UTC";
    return html`<t-admin-tabs page="audit"></t-admin-tabs>
      <div class="head">
        <div>
          <h1>${msg("Audit log")}</h1>
          <p class="muted">${msg("Every row is sealed to the one before: one that is changed or taken out breaks the chain.")}</p>
          <div role="status">${this.renderChain()}</div>
        </div>
        <div class="actions">
          <a download href=${`/api/audit/export?${writeAuditFilter(filter)}`}>${msg("Export as CSV")}</a>
          <t-button ?busy=${this.action.busy} @click=${this.verifyChain}>${msg("Verify the chain")}</t-button>
        </div>
      </div>
      <t-audit-filter
        class="sheet"
        .filter=${filter}
        .sites=${this.sites.store?.list ?? []}
        zone=${zone}
        @t-filter=${this.onChoose}
      ></t-audit-filter>
      ${renderLoaded(this.page, msg("the audit log"), (page) => this.renderRows(page, filter))}
      <t-witnessed-hubs class="sheet"></t-witnessed-hubs>`;
  }

  private renderChain(): unknown {
    const { problem } = this.action;
    if (problem !== null) return renderAdvice(problem);
    const { check } = this;
    if (check === null) return nothing;
    const rows = plural(check.rows, msg("1 row"), msg(str`${String(check.rows)} rows`));
    const heads = plural(check.heads ?? 0, msg("1 signed head"), msg(str`${String(check.heads)} signed heads`));
    if (check.problem !== "" && check.broken === 0) {
      return html`<t-problem
        what=${msg("The signed heads of the log cannot be used.")}
        how=${msg(str`${check.problem ?? ""} Hold the log against the heads that you keep elsewhere: talaia audit verify --heads FILE.`)}
      ></t-problem>`;
    }
    return check.ok
      ? html`<t-status kind="ok" word=${msg(str`The chain holds: ${rows}, each follows from the one before; ${heads} fit.`)}></t-status>`
      : html`<t-problem
          what=${msg(str`The chain is broken at row ${String(check.broken)}.`)}
          how=${msg(str`${rows} before it hold. Somebody has changed the database by hand, or it is damaged: keep a copy of it, and compare it with your exports and backups.`)}
        ></t-problem>`;
  }

  private renderRows(page: AuditList, filter: AuditFilter): TemplateResult {
    if (page.rows.length === 0) {
      return html`<t-empty heading=${msg("No matches")} icon="info">
        <p>${writeAuditFilter(filter) === "" ? msg("The log is empty.") : msg("No row matches the filter.")}</p>
        ${writeAuditFilter(filter) === "" ? nothing : html`<t-button @click=${this.clearFilter}>${msg("Show everything")}</t-button>`}
      </t-empty>`;
    }
    return html`${renderTable({
        label: msg("Audit log"),
        columns: this.columns,
        rows: page.rows,
        key: ({ id }) => id,
        busy: this.page.result.state === "loading",
      })}
      <div class="actions paging">
        ${this.trail.length === 0
          ? nothing
          : html`<t-button @click=${this.showNewest}>${msg("Newest")}</t-button><t-button @click=${this.showNewer}>${msg("Newer")}</t-button>`}
        ${page.more ? html`<t-button @click=${this.showOlder}>${msg("Older")}</t-button>` : html`<span class="muted">${msg("This is the oldest.")}</span>`}
      </div>`;
  }

  private readonly columns: readonly TableColumn<AuditRow>[] = [
    { title: msg("Time"), name: "when", cell: ({ time_us, site }) => html`<t-time .us=${time_us} .zone=${this.sites.store?.zoneOf(site) ?? "UTC"}></t-time>` },
    { title: msg("Who"), name: "who", cell: renderPerson },
    { title: msg("What"), name: "what", cell: ({ kind, message }) => html`<strong>${eventWords(kind)}</strong> ${message === "" ? nothing : html`<span>${message}</span>`}` },
    { title: msg("Where"), name: "where", cell: ({ site, device, source }) => [site, device, source === "gateway" ? msg("said by the gateway") : ""].filter(Boolean).join(" · ") || html`<span class="muted">${msg("hub")}</span>` },
    { title: msg("Outcome"), cell: ({ good }) => html`<t-status kind=${good ? "ok" : "bad"} word=${good ? msg("done", { id: "done.outcome" }) : msg("refused", { id: "refused.outcome" })}></t-status>` },
  ];

  private filter(): AuditFilter {
    return readAuditFilter(this.router.store?.search ?? "");
  }

  private readonly onChoose = (event: CustomEvent<AuditFilter>): void => {
    this.router.store?.replace(withQuery("/admin/audit", writeAuditFilter(event.detail)));
  };

  private readonly clearFilter = (): void => {
    this.router.store?.replace(withQuery("/admin/audit", writeAuditFilter(NO_FILTER)));
  };

  private readonly showOlder = (): void => {
    const last = this.page.value?.rows.at(-1);
    if (last !== undefined) this.trail = [...this.trail, last.id];
    window.scrollTo(0, 0);
  };

  private readonly showNewer = (): void => {
    this.trail = this.trail.slice(0, -1);
  };

  private readonly showNewest = (): void => {
    this.trail = [];
    this.page.invalidate();
  };

  private readonly verifyChain = (): void => {
    this.check = null;
    void this.action.run(msg("verify the chain"), async () => {
      this.check = await new AdminApi(this.api).checkAudit();
    });
  };
}

function renderPerson({ who, address }: AuditRow): TemplateResult {
  return html`${who === "" ? html`<span class="muted">${msg("nobody")}</span>` : who}
  ${address === "" ? nothing : html`<span class="muted small">${address}</span>`}`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-audit": PageAudit;
  }
}
