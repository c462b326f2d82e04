/** Requests for a site's nights: the list with its filter, one of them, and the form of a new one. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { FilterForm } from "../../controllers/filter-form.js";
import { InfiniteList } from "../../controllers/infinite-list.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { settled } from "../../elements/base/stable-field.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { formatDuration } from "../../format/duration.js";
import { formTexts } from "../../format/filter-query.js";
import { REQUEST_WORDS, URGENCY_WORDS } from "../../format/observing-words.js";
import type { GroupShape, ProposalList, RequestRow, SiteShape } from "../../generated/api.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { sitePath, withQuery } from "../../state/router.js";
import type { HubApi } from "../../wire/hub-api.js";
import { ObservingApi } from "../../wire/observing-api.js";
import { renderInfiniteList } from "../infinite-list-view.js";
import { FILTER_KEYS, NO_FILTER, readRequestsFilter, requestsPageQuery, STATES, writeRequestsFilter, type RequestsFilter } from "./requests-query.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/loading.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../../elements/values/time.js";
import "./request-detail.js";
import "./form/request-form.js";
import "./request-import.js";

const ROWS = 50;

@customElement("t-page-requests")
export class PageRequests extends LitElement {
  static override styles = [base, sheets, forms];

  @property() site = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly proposals = new LoadController<ProposalList>(this);
  private readonly edited = new LoadController<GroupShape | null>(this);
  private readonly list = new InfiniteList<RequestRow>(this, async (before) => {
    const { requests, more } = await new ObservingApi(this.api, this.site).findRequests(requestsPageQuery(this.filter(), before, ROWS));
    return { rows: requests, more };
  });
  private readonly form = new FilterForm<RequestsFilter>(
    this,
    (said) => ({ ...formTexts(said, FILTER_KEYS), mine: said.has("mine"), waiting: said.has("waiting") }),
    (filter) => {
      this.router.store?.replace(withQuery(sitePath(this.site, "requests"), writeRequestsFilter(filter)));
    },
    NO_FILTER,
  );

  constructor() {
    super();
    new ConnectionStateController(this, (connection) => [
      connection.onMessage("observing_request", (news) => {
        if (news.site === this.site) this.list.scheduleRefresh();
      }),
    ]);
  }

  override willUpdate(): void {
    const sites = this.sites.store;
    if (sites !== undefined) this.detail.load(`${this.site} ${sites.catalogueOf(this.site)}`, () => sites.loadDetail(this.site));
    const api = new ObservingApi(this.api, this.site);
    this.proposals.load(this.site, () => api.listProposals());
    const opened = this.asked("edit") || this.asked("again");
    this.edited.load(`${this.site} ${opened}`, async () => (opened === "" ? null : (await api.requestDetail(opened)).group));
    this.list.load(`${this.site}\n${writeRequestsFilter(this.filter())}`);
  }

  override render(): TemplateResult {
    const open = this.asked("request");
    const isImport = this.asked("import") !== "";
    const isForm = isImport || ["new", "edit", "again"].some((name) => this.asked(name) !== "");
    const known = this.proposals.value;
    return html`${renderPageHead(
        msg("Requests"),
        msg(str`What is asked of the nights of ${this.sites.store?.siteRow(this.site)?.name ?? this.site}.`),
        html`<div class="actions">
          ${known?.may_request === true && known.observes && !isForm
            ? html`<t-button kind="primary" @click=${this.openNew}>${msg("New request")}</t-button><t-button @click=${this.openImport}>${msg("Import…")}</t-button>`
            : nothing}
          <a href=${sitePath(this.site, "night")}>${msg("Night")}</a>
          <a href=${sitePath(this.site, "proposals")}>${msg("Proposals")}</a>
        </div>`,
      )}
      ${isForm ? this.renderForm(isImport) : nothing}
      ${open === "" || isForm
        ? nothing
        : html`<t-request-detail
            .site=${this.site}
            .request=${open}
            .place=${this.detail.value?.place ?? null}
            .zone=${this.zone}
            @t-changed=${this.onChanged}
            .mayAsk=${known?.may_request === true && known.proposals.some(({ may_ask: may, active }) => may && active)}
            @t-edit=${this.openEdit}
            @t-again=${this.openAgain}
            @t-close=${this.closeAll}
          ></t-request-detail>`}
      ${isForm ? nothing : renderLoaded(this.proposals, msg("the proposals"), (proposals) => this.renderList(proposals))}`;
  }

  private renderForm(isImport: boolean): unknown {
    const opened = this.asked("edit") || this.asked("again");
    return renderLoaded(this.proposals, msg("the proposals"), ({ proposals, abilities, may_request: may }) =>
      may && proposals.some(({ may_ask: ask }) => ask)
        ? isImport
          ? html`<t-request-import .site=${this.site} .proposals=${proposals} .zone=${this.zone} @t-imported=${this.onImported} @t-cancel=${this.closeAll}></t-request-import>`
          : renderLoaded(
              this.edited,
              msg("this request"),
              // While it loads, what was open before is still there.
              (group) => opened !== "" && group?.requests.some(({ id }) => id === opened) !== true ? html`<t-loading what=${msg("Loading this request")}></t-loading>` : html`<t-request-form
                .site=${this.site}
                .proposals=${proposals}
                .abilities=${abilities}
                .place=${this.detail.value?.place ?? null}
                .zone=${this.zone}
                .group=${group}
                ?again=${this.asked("again") !== ""}
                @t-saved=${this.onSaved}
                @t-cancel=${this.closeAll}
              ></t-request-form>`,
            )
        : html`<t-empty heading=${msg("You may not ask for observations here")} icon="lock">
            <p>${msg("It takes the right “request” at this site and to be a member of a proposal. An admin of the site can give you both.")}</p>
          </t-empty>`,
    );
  }

  private renderList({ proposals, observes }: ProposalList): TemplateResult {
    const filter = this.filter();
    return html`<section class="sheet" aria-label=${msg("Filter")}>
        <form class="filter" novalidate @submit=${this.form.onSubmit} @input=${this.form.onInput}>
          <t-field label=${msg("Search")}><input name="text" type="search" maxlength="200" autocomplete="off" .value=${settled(filter.text)} /></t-field>
          <t-field label=${msg("Proposal")}><select name="proposal">${renderOptions([["", msg("All", { id: "all.proposals" })], ...proposals.map(({ id, title }) => [id, title === "" ? id : title] as const)], filter.proposal)}</select></t-field>
          <t-field label=${msg("State")}><select name="state">${renderOptions([["", msg("All", { id: "all.states" })], ...STATES.map((state) => [state, REQUEST_WORDS[state].word] as const)], filter.state)}</select></t-field>
          <label class="tick"><input name="mine" type="checkbox" .checked=${filter.mine} /> ${msg("Mine")}</label>
          <label class="tick"><input name="waiting" type="checkbox" .checked=${filter.waiting} /> ${msg("To be approved")}</label>
          <t-button kind="quiet" ?disabled=${writeRequestsFilter(filter) === ""} @click=${this.form.clearFilter}>${msg("Clear")}</t-button>
        </form>
      </section>
      ${renderInfiniteList(this.list, {
        label: msg("Requests"),
        what: msg("the requests"),
        row: (row) => this.renderRow(row),
        nothing: () => this.renderEmpty(filter, observes),
      })}`;
  }

  private renderEmpty(filter: RequestsFilter, observes: boolean): TemplateResult {
    if (writeRequestsFilter(filter) !== "") {
      return html`<t-empty heading=${msg("No matches")} icon="logbook"><p>${msg("No request is like this.")}</p><t-button @click=${this.form.clearFilter}>${msg("Show everything")}</t-button></t-empty>`;
    }
    return html`<t-empty heading=${msg("No requests")} icon="logbook">
      <p>${observes ? msg("Nobody has asked for anything that is open to you.") : msg("This site does not observe by itself: its description has no section night.")}</p>
    </t-empty>`;
  }

  private renderRow(row: RequestRow): TemplateResult {
    const { word, kind } = REQUEST_WORDS[row.state];
    return html`<li>
      <div>
        <a class="name" href=${this.pathOf({ request: row.id })}>${row.target === "" ? row.group_name || msg("no target") : row.target}</a>
        <div class="facts">
          <t-status kind=${kind} word=${row.waits ? msg("waits to be approved") : word}></t-status>
          <span>${row.proposal}</span><span>${row.requester}</span>${row.urgency === "NORMAL" ? nothing : html`<span class="chip">${URGENCY_WORDS[row.urgency]}</span>`}
          <span>${msg(str`charged ${formatDuration(row.charge_s)}`)}</span>
          <span>${msg(html`window to <t-time short .us=${row.end_us} .zone=${this.zone}></t-time>`)}</span>
        </div>
        ${row.why_not === null ? nothing : html`<div>${row.why_not.message}</div>`}
      </div>
    </li>`;
  }

  private get zone(): string {
    return this.sites.store?.zoneOf(this.site) ?? "UTC";
  }

  private asked(name: string): string {
    return new URLSearchParams(this.router.store?.search ?? "").get(name) ?? "";
  }

  private filter(): RequestsFilter {
    return readRequestsFilter(this.router.store?.search ?? "");
  }

  private pathOf(more: Readonly<Record<string, string>> = {}): string {
    const query = new URLSearchParams(writeRequestsFilter(this.filter()));
    for (const [name, value] of Object.entries(more)) query.set(name, value);
    return withQuery(sitePath(this.site, "requests"), query.toString());
  }

  private readonly openNew = (): void => {
    this.router.store?.navigate(this.pathOf({ new: "1" }));
  };

  private readonly openImport = (): void => {
    this.router.store?.navigate(this.pathOf({ import: "1" }));
  };

  private readonly onImported = (): void => {
    this.onChanged();
    this.closeAll();
  };

  /** The form of a group is opened by one of its requests. */
  private readonly openEdit = (): void => {
    this.edited.invalidate();
    this.router.store?.navigate(this.pathOf({ edit: this.asked("request") }));
  };

  private readonly openAgain = (): void => {
    this.edited.invalidate();
    this.router.store?.navigate(this.pathOf({ again: this.asked("request") }));
  };

  private readonly closeAll = (): void => {
    this.router.store?.navigate(this.pathOf());
  };

  private readonly onSaved = (event: CustomEvent<GroupShape>): void => {
    this.onChanged();
    const [first] = event.detail.requests;
    this.router.store?.navigate(first === undefined ? this.pathOf() : this.pathOf({ request: first.id }));
  };

  private readonly onChanged = (): void => {
    this.list.scheduleRefresh();
    this.proposals.invalidate();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-requests": PageRequests;
  }
}
