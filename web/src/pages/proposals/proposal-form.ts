/** What a proposal may use, as a form for admins of its site. */

import { msg, str } from "@lit/localize";
import { html, LitElement, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import { focusInside } from "../../elements/base/focus.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { renderFormActions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import type { Advice } from "../../format/error-advice.js";
import { submittedForm } from "../../format/form-values.js";
import type { ProposalAsk, ProposalShape } from "../../generated/api.js";
import { readProposal, type ProposalField } from "./proposal-fields.js";
import "../../elements/forms/field.js";

/**
 * @fires t-proposal detail is what shall be kept
 * @fires t-cancel
 */
@customElement("t-proposal-form")
export class ProposalForm extends LitElement {
  static override styles = [base, sheets, forms];

  /** Null for a new one. */
  @property({ attribute: false }) proposal: ProposalShape | null = null;
  @property({ attribute: false }) problem: Advice | null = null;
  @property({ type: Boolean }) busy = false;
  @state() private problems: ReadonlyMap<ProposalField, string> = new Map();

  override firstUpdated(): void {
    void focusInside(this, "input");
  }

  override render(): TemplateResult {
    const { proposal } = this;
    const errorOf = (field: ProposalField): string => this.problems.get(field) ?? "";
    const urgent = (urgency: "TIME_CRITICAL" | "RAPID_RESPONSE"): boolean => proposal?.urgencies.includes(urgency) ?? false;
    return html`<form class="entry sheet" novalidate @submit=${this.onSubmit}>
      <h2>${proposal === null ? msg("New proposal") : msg(str`Change ${proposal.id}`)}</h2>
      <t-field label=${msg("Id")} hint=${msg("Short, as on forms; it stays")} .error=${errorOf("id")}>
        <input name="id" maxlength="64" autocomplete="off" autocapitalize="none" spellcheck="false" ?readonly=${proposal !== null} .value=${proposal?.id ?? ""} />
      </t-field>
      <t-field label=${msg("Title")}><input name="title" maxlength="200" autocomplete="off" .value=${proposal?.title ?? ""} /></t-field>
      <t-field label=${msg("Share of the time (%)")} hint=${msg("What it is due beside others")} .error=${errorOf("share")}>
        <input name="share" inputmode="decimal" autocomplete="off" .value=${String(Math.round((proposal?.share ?? 0) * 1000) / 10)} />
      </t-field>
      <t-field label=${msg("Hours in all")} .error=${errorOf("hours")}><input name="hours" inputmode="decimal" autocomplete="off" .value=${String(proposal?.hours_allocated ?? "")} /></t-field>
      <t-field label=${msg("Hours of each member")} hint=${msg("0: as much as there is")} .error=${errorOf("person")}>
        <input name="person" inputmode="decimal" autocomplete="off" .value=${String(proposal?.person_hours ?? 0)} />
      </t-field>
      <t-field label=${msg("Highest priority")} .error=${errorOf("priority")}>
        <input name="priority" inputmode="decimal" autocomplete="off" .value=${String(proposal?.max_priority ?? 20)} />
      </t-field>
      <label class="tick"><input name="active" type="checkbox" .checked=${proposal?.active ?? true} /> ${msg("Active")}</label>
      <label class="tick"><input name="approval" type="checkbox" .checked=${proposal?.needs_approval ?? false} /> ${msg("Requests need approval")}</label>
      <label class="tick"><input name="open" type="checkbox" .checked=${proposal?.is_open ?? false} /> ${msg("Whoever may view the site sees its requests")}</label>
      <label class="tick"><input name="critical" type="checkbox" .checked=${urgent("TIME_CRITICAL")} /> ${msg("May ask for time-critical")}</label>
      <label class="tick"><input name="rapid" type="checkbox" .checked=${urgent("RAPID_RESPONSE")} /> ${msg("May ask for rapid response")}</label>
      ${renderAdvice(this.problem)} ${renderFormActions({ submit: msg("Keep"), busy: this.busy, cancel: this.onCancel })}
    </form>`;
  }

  private readonly onSubmit = (event: SubmitEvent): void => {
    const said = submittedForm(event);
    if (said === undefined || this.busy) return;
    const { asked, problems } = readProposal(said);
    this.problems = problems;
    if (asked !== null) this.dispatchEvent(new CustomEvent("t-proposal", { detail: asked }));
  };

  private readonly onCancel = (): void => {
    this.dispatchEvent(new CustomEvent("t-cancel"));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-proposal-form": ProposalForm;
  }
  interface GlobalEventHandlersEventMap {
    "t-proposal": CustomEvent<ProposalAsk>;
  }
}
