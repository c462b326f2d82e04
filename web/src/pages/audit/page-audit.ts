/** The audit log: who did what, and whether the chain of its rows holds. */

import { consume } from "@lit/context";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { withQuery } from "../../state/router.js";
import type { AuditCheck, AuditPage, AuditRow } from "../../wire/admin-types.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { auditStyle } from "./audit-style.js";
import { NO_FILTER, auditPageQuery, readAuditFilter, writeAuditFilter, type AuditFilter } from "./audit-query.js";
import { renderAdvice, renderLoadError, renderLoadingNote } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/problem.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";
import "../admin-tabs.js";
import "./audit-filter.js";

const ROWS = 50;
const TITLES = ["Time", "Who", "What", "Where", "Outcome"] as const;

@customElement("t-page-audit")
export class PageAudit extends LitElement {
  static override styles = [base, sheets, auditStyle];

  /** The last row of each page before this one. */
  @state() private trail: readonly string[] = [];
  @state() private check: AuditCheck | null = null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly page = new LoadController<AuditPage>(this);
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
          <h1>Audit log</h1>
          <p class="muted">Every row is sealed to the one before: one that is changed or taken out breaks the chain.</p>
          <div role="status">${this.renderChain()}</div>
        </div>
        <div class="actions">
          <a class="export" download href=${`/api/audit/export?${writeAuditFilter(filter)}`}>Export as CSV</a>
          <t-button ?busy=${this.action.busy} @click=${this.verifyChain}>Verify the chain</t-button>
        </div>
      </div>
      <t-audit-filter
        class="sheet"
        .filter=${filter}
        .sites=${this.sites.store?.list ?? []}
        zone=${zone}
        @t-filter=${this.onChoose}
      ></t-audit-filter>
      ${renderLoadError(this.page.result, "the audit log", this.retry)} ${this.renderRows(filter)}`;
  }

  private renderChain(): unknown {
    const { problem } = this.action;
    if (problem !== null) return renderAdvice(problem);
    const { check } = this;
    if (check === null) return nothing;
    const rows = check.rows === 1 ? "1 row" : `${String(check.rows)} rows`;
    return check.ok
      ? html`<t-status kind="ok" word=${`The chain holds: ${rows}, each follows from the one before.`}></t-status>`
      : html`<t-problem
          what=${`The chain is broken at row ${String(check.broken)}.`}
          how=${`${rows} before it hold. Somebody has changed the database by hand, or it is damaged: keep a copy of it, and compare it with your exports and backups.`}
        ></t-problem>`;
  }

  private renderRows(filter: AuditFilter): unknown {
    const page = this.page.value;
    if (page === undefined) {
      return renderLoadingNote(this.page.result, "Loading the audit log");
    }
    if (page.rows.length === 0) {
      return html`<t-empty heading="No matches" icon="info">
        <p>${writeAuditFilter(filter) === "" ? "The log is empty." : "No row matches the filter."}</p>
        ${writeAuditFilter(filter) === "" ? nothing : html`<t-button @click=${this.clearFilter}>Show everything</t-button>`}
      </t-empty>`;
    }
    return html`<div class="table" role="table" aria-label="Audit log" aria-busy=${this.page.result.state === "loading"}>
        <div class="row titles" role="row">
          ${map(TITLES, (word) => html`<span role="columnheader">${word}</span>`)}
        </div>
        ${repeat(
          page.rows,
          (row) => row.id,
          (row) => this.renderRow(row),
        )}
      </div>
      <div class="actions paging">
        ${this.trail.length === 0
          ? nothing
          : html`<t-button @click=${this.showNewest}>Newest</t-button><t-button @click=${this.showNewer}>Newer</t-button>`}
        ${page.more ? html`<t-button @click=${this.showOlder}>Older</t-button>` : html`<span class="muted">This is the oldest.</span>`}
      </div>`;
  }

  private renderRow(row: AuditRow): TemplateResult {
    return html`<div class="row" role="row">
      <span role="cell" class="when"><t-time .us=${row.time_us} .zone=${this.sites.store?.zoneOf(row.site) ?? "UTC"}></t-time></span>
      <span role="cell" class="who"
        >${row.who === "" ? html`<span class="muted">nobody</span>` : row.who}
        ${row.address === "" ? nothing : html`<span class="muted small">${row.address}</span>`}</span
      >
      <span role="cell" class="what"
        ><strong>${row.kind}</strong> ${row.message === "" ? nothing : html`<span>${row.message}</span>`}</span
      >
      <span role="cell" class="where">${[row.site, row.device].filter(Boolean).join(" · ") || html`<span class="muted">hub</span>`}</span>
      <span role="cell"><t-status kind=${row.good ? "ok" : "bad"} word=${row.good ? "done" : "refused"}></t-status></span>
    </div>`;
  }

  private filter(): AuditFilter {
    return readAuditFilter(this.router.store?.search ?? "");
  }

  private readonly onChoose = (event: CustomEvent<AuditFilter>): void => {
    this.router.store?.replace(withQuery("/admin/audit", writeAuditFilter(event.detail)));
  };

  private readonly clearFilter = (): void => {
    this.router.store?.replace(withQuery("/admin/audit", writeAuditFilter(NO_FILTER)));
  };

  private readonly retry = (): void => {
    this.page.invalidate();
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
    void this.action.run("verify the chain", async () => {
      this.check = await new AdminApi(this.api).checkAudit();
    });
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-audit": PageAudit;
  }
}
