/** Proposals of a site: who is in them, which share and hours they have; admins of the site change them. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { URGENCY_WORDS } from "../../format/observing-words.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { base } from "../../elements/base/base-style.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { renderRowSheet } from "../../elements/layout/rows.js";
import { fixedText } from "../../format/number.js";
import type { ProposalAsk, ProposalList, ProposalShape } from "../../generated/api.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import type { HubApi } from "../../wire/hub-api.js";
import { proposalPicturesPath } from "../../wire/archive-api.js";
import { ObservingApi } from "../../wire/observing-api.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "./proposal-form.js";
import "./proposal-members.js";

@customElement("t-page-proposals")
export class PageProposals extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      progress {
        inline-size: min(16rem, 100%);
      }
    `,
  ];

  @property() site = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly proposals = new LoadController<ProposalList>(this);
  private readonly action = new ActionController(this);
  /** The proposal whose form is open: its id, or `new`. */
  private readonly form = new OpenSubject<ProposalShape | "new">(this);

  override willUpdate(): void {
    this.proposals.load(this.site, () => new ObservingApi(this.api, this.site).listProposals());
  }

  override render(): TemplateResult {
    const known = this.proposals.value;
    return html`${renderPageHead(
        msg("Proposals"),
        msg(str`Who may use the nights of ${this.sites.store?.siteRow(this.site)?.name ?? this.site}, and how much of them.`),
        html`<div class="actions">
          ${known?.may_manage === true && known.observes
            ? html`<t-button kind="primary" ?hidden=${this.form.isOpen} @click=${this.form.opener("new")}>${msg("New proposal")}</t-button>`
            : nothing}
          <a href=${sitePath(this.site, "alertrules")}>${msg("Alert rules")}</a>
          <a href=${sitePath(this.site, "night")}>${msg("Night")}</a>
          <a href=${sitePath(this.site, "requests")}>${msg("Requests")}</a>
        </div>`,
      )}
      <p class="visually-hidden" role="status">${this.action.doneText}</p>
      ${this.form.subject === null
        ? nothing
        : html`<t-proposal-form
            .proposal=${this.form.subject === "new" ? null : this.form.subject}
            .problem=${this.action.problem}
            ?busy=${this.action.busy}
            @t-proposal=${this.saveProposal}
            @t-cancel=${this.closeForm}
          ></t-proposal-form>`}
      ${renderLoaded(this.proposals, msg("the proposals"), (list) => this.renderList(list))}`;
  }

  private renderList({ proposals, may_manage: manages, observes }: ProposalList): TemplateResult {
    if (proposals.length === 0) {
      return html`<t-empty heading=${msg("No proposals")} icon="people">
        <p>
          ${observes
            ? manages
              ? msg("Without a proposal nobody can ask for anything: make the first one.")
              : msg("None is open to you. An admin of the site can make you a member of one.")
            : msg("This site does not observe by itself: its description has no section night.")}
        </p>
      </t-empty>`;
    }
    return renderRowSheet(msg("Proposals"), proposals, (proposal) => this.renderProposal(proposal, manages));
  }

  private renderProposal(proposal: ProposalShape, manages: boolean): TemplateResult {
    const { id, title, share, hours_allocated: hours, used_s: used, promised_s: promised, active, needs_approval: approval, is_open: open } = proposal;
    const facts = [approval ? msg("needs approval") : "", open ? msg("open to whoever may view the site") : "", ...proposal.urgencies.map((urgency) => URGENCY_WORDS[urgency])];
    return html`<li>
      <div>
        <a class="name" href=${`${sitePath(this.site, "requests")}?proposal=${encodeURIComponent(id)}`}>${title === "" ? id : `${id}: ${title}`}</a>
        <div class="facts">
          <t-status kind=${active ? "ok" : "unknown"} word=${active ? msg("active") : msg("ended")}></t-status>
          <span>${msg(str`share ${(share * 100).toFixed(0)} %`)}</span>
          <span>${msg(str`${fixedText(used / 3600, 1)} h used, ${fixedText(promised / 3600, 1)} h asked for, of ${hours} h`)}</span>
          ${map(facts.filter(Boolean), (fact) => html`<span>${fact}</span>`)}
        </div>
        ${used > 0 ? html`<a download=${`${id}.tar`} href=${proposalPicturesPath(this.site, id)}>${msg("Download its pictures")}</a>` : nothing}
        <progress aria-label=${msg(str`Hours of ${id}`)} max=${Math.max(hours, 0.001)} .value=${Math.min(hours, (used + promised) / 3600)}></progress>
        <t-proposal-members .site=${this.site} .proposal=${proposal} ?manages=${manages} @t-changed=${this.proposals.invalidate}></t-proposal-members>
      </div>
      ${manages ? html`<div class="actions"><t-button label=${msg(str`Change ${id}`)} ?hidden=${this.form.isOpen} @click=${this.form.opener(proposal)}>${msg("Change…")}</t-button></div>` : nothing}
    </li>`;
  }

  private readonly closeForm = (): void => {
    this.form.close();
    this.action.clear();
  };

  private readonly saveProposal = (event: CustomEvent<ProposalAsk>): void => {
    const { id, ...change } = event.detail;
    const api = new ObservingApi(this.api, this.site);
    const isNew = this.form.subject === "new";
    void this.action.run(msg(str`keep the proposal ${id}`), () => (isNew ? api.addProposal({ id, ...change }) : api.changeProposal(id, change)), msg(str`${id} is kept.`)).then((done) => {
      if (done) this.form.close();
      this.proposals.invalidate();
    });
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-proposals": PageProposals;
  }
}
