/** Rules by which notices of transients become rapid requests: those of a proposal, and the form of one. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { QuestionController } from "../../controllers/question.js";
import { base } from "../../elements/base/base-style.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { renderRowSheet } from "../../elements/layout/rows.js";
import type { AlertRuleList, AlertRuleShape, ProposalList, ProposalShape } from "../../generated/api.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { sitePath, withQuery } from "../../state/router.js";
import { AlertRulesApi } from "../../wire/alert-rules-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { ObservingApi } from "../../wire/observing-api.js";
import { filterText } from "./rule-draft.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "./rule-form.js";

@customElement("t-page-alert-rules")
export class PageAlertRules extends LitElement {
  static override styles = [base, sheets, forms];

  @property() site = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly proposals = new LoadController<ProposalList>(this);
  private readonly rules = new LoadController<AlertRuleList | null>(this);
  /** The rule whose form is open. */
  private readonly form = new OpenSubject<AlertRuleShape | "new">(this);
  private readonly question = new QuestionController<AlertRuleShape>(this, async (rule, action) => {
    const done = await action.run(msg(str`remove the rule ${rule.name}`), () => this.rulesApi().removeRule(rule.id));
    this.rules.invalidate();
    return done;
  });

  override willUpdate(): void {
    this.proposals.load(this.site, () => new ObservingApi(this.api, this.site).listProposals());
    const proposal = this.chosen()?.id ?? "";
    this.rules.load(`${this.site} ${proposal}`, async () => (proposal === "" ? null : this.rulesApi().listRules()));
  }

  override render(): TemplateResult {
    const links = html`<div class="actions">
      ${this.rules.value?.may_change === true && !this.form.isOpen ? html`<t-button kind="primary" @click=${this.form.opener("new")}>${msg("New rule")}</t-button>` : nothing}
      <a href=${sitePath(this.site, "proposals")}>${msg("Proposals")}</a>
      <a href=${sitePath(this.site, "requests")}>${msg("Requests")}</a>
    </div>`;
    return html`${renderPageHead(msg("Alert rules"), msg(str`Which notices of transients become rapid requests at ${this.sites.store?.siteRow(this.site)?.name ?? this.site}.`), links)}
    ${renderLoaded(this.proposals, msg("the proposals"), (list) => this.renderProposals(list))}`;
  }

  private renderProposals({ proposals, abilities }: ProposalList): TemplateResult {
    const own = ownProposals(proposals);
    const chosen = this.chosen();
    if (chosen === undefined) {
      return html`<t-empty heading=${msg("No rules")} icon="lock"><p>${msg("Rules belong to a proposal: members see its rules, and who leads it changes them. You are in none here.")}</p></t-empty>`;
    }
    const { subject } = this.form;
    return html`<section class="sheet" aria-label=${msg("Proposal")}>
        <form class="entry" @change=${this.onChoose}>
          <t-field label=${msg("Proposal")}><select name="proposal" ?disabled=${subject !== null}>${renderOptions(own.map(({ id, title }) => [id, title === "" ? id : `${id}: ${title}`] as const), chosen.id)}</select></t-field>
        </form>
        ${chosen.urgencies.includes("RAPID_RESPONSE") ? nothing : html`<p><t-status kind="warn" word=${msg("no rapid requests")}></t-status> ${msg("This proposal may not ask for them, so its rules make nothing. An admin of the site can change that.")}</p>`}
      </section>
      ${subject === null
        ? nothing
        : html`<t-alert-rule-form
            .site=${this.site}
            .proposal=${chosen}
            .abilities=${abilities}
            .rule=${subject === "new" ? null : subject}
            .zone=${this.sites.store?.zoneOf(this.site) ?? "UTC"}
            @t-saved=${this.onSaved}
            @t-cancel=${this.form.close}
          ></t-alert-rule-form>`}
      ${renderLoaded(this.rules, msg("the rules"), (list) => (list === null ? nothing : this.renderRules(list)))}
      ${renderQuestion(this.question, ({ name }) => ({ heading: msg(str`Remove the rule ${name}?`), action: msg("Remove"), text: msg("No notice becomes a request by it any more. What it has asked for stays.") }))}`;
  }

  private renderRules({ rules, may_change: may }: AlertRuleList): TemplateResult {
    if (rules.length === 0) {
      return html`<t-empty heading=${msg("No rules")} icon="logbook">
        <p>${may ? msg("No notice becomes a request of this proposal yet: make a rule, and see first what the last notices would have made.") : msg("Who leads the proposal and is in it makes them.")}</p>
      </t-empty>`;
    }
    return renderRowSheet(msg("Rules"), rules, (rule) => this.renderRule(rule, may));
  }

  private renderRule(rule: AlertRuleShape, may: boolean): TemplateResult {
    const { name, filter = {}, configurations, hours = 24, priority = 10, active = true, maker } = rule;
    const frames = configurations.map(({ count = 1, exposure, filter: by = "" }) => `${String(count)} × ${String(exposure)} s${by === "" ? "" : ` ${by}`}`).join(", ");
    return html`<li>
      <div>
        <span class="name">${name}</span>
        <div>${filterText(filter)}</div>
        <div class="facts">
          <t-status kind=${active ? "ok" : "unknown"} word=${active ? msg("active") : msg("off", { id: "off.rule" })}></t-status>
          <span>${frames}</span><span>${msg(str`within ${hours} h of the event`)}</span><span>${msg(str`priority ${priority}`)}</span>
          ${maker === "" ? html`<t-status kind="warn" word=${msg("its maker is gone: it makes nothing")}></t-status>` : html`<span>${msg(str`asks in the name of ${maker}`)}</span>`}
        </div>
      </div>
      ${may && !this.form.isOpen
        ? html`<div class="actions">
            <t-button label=${msg(str`Change ${name}`)} @click=${this.form.opener(rule)}>${msg("Change…")}</t-button>
            <t-button kind="quiet" label=${msg(str`Remove ${name}`)} @click=${this.question.opener(rule)}>${msg("Remove…")}</t-button>
          </div>`
        : nothing}
    </li>`;
  }

  private rulesApi(): AlertRulesApi {
    return new AlertRulesApi(this.api, this.site, this.chosen()?.id ?? "");
  }

  /** The proposal that the address names, else the first of one's own that may ask for rapid requests. */
  private chosen(): ProposalShape | undefined {
    const own = ownProposals(this.proposals.value?.proposals ?? []);
    const asked = new URLSearchParams(this.router.store?.search ?? "").get("proposal");
    return own.find(({ id }) => id === asked) ?? own.find(({ urgencies }) => urgencies.includes("RAPID_RESPONSE")) ?? own[0];
  }

  private readonly onChoose = (event: Event): void => {
    if (!(event.target instanceof HTMLSelectElement)) return;
    this.router.store?.replace(withQuery(sitePath(this.site, "alertrules"), new URLSearchParams({ proposal: event.target.value }).toString()));
  };

  private readonly onSaved = (): void => {
    this.form.close();
    this.rules.invalidate();
  };
}

/** Those whose rules one may see. */
function ownProposals(proposals: readonly ProposalShape[]): readonly ProposalShape[] {
  return proposals.filter(({ may_ask: asks, may_lead: leads, role }) => asks || leads || role !== null);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-alert-rules": PageAlertRules;
  }
}
