/** A rule as a form: what a notice must be, what is then asked for, and what the last notices would have made. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { base } from "../../elements/base/base-style.js";
import { focusInside } from "../../elements/base/focus.js";
import { settled } from "../../elements/base/stable-field.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { forms } from "../../elements/forms/form-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import type { AbilitiesShape, AlertRuleShape, ProposalShape } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import { AlertRulesApi } from "../../wire/alert-rules-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderConstraints } from "../requests/form/constraint-fields.js";
import { DraftEditor } from "../requests/form/draft-editor.js";
import { formStyle } from "../requests/form/form-style.js";
import { numberInput, type FormView } from "../requests/form/form-view.js";
import { renderFrames } from "../requests/form/frame-fields.js";
import { readGroup } from "../requests/form/read-draft.js";
import { NEW_RULE, readRule, ROLES, ruleDraft, ruleGroup, type ReadRule, type RuleDraft, type RuleField } from "./rule-draft.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "./rule-preview.js";

const OWN_FIELD = /^rule\.(\w+)$/;

/**
 * @fires t-saved
 * @fires t-cancel
 */
@customElement("t-alert-rule-form")
export class AlertRuleForm extends LitElement {
  static override styles = [
    base,
    sheets,
    forms,
    formStyle,
    css`
      textarea {
        min-block-size: 6rem;
        resize: vertical;
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) proposal: ProposalShape | null = null;
  @property({ attribute: false }) abilities: AbilitiesShape | null = null;
  @property() zone = "UTC";
  /** The rule that is changed; null for a new one. */
  @property({ attribute: false }) rule: AlertRuleShape | null = null;
  @state() private draft: RuleDraft = NEW_RULE;
  @state() private tried = false;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);
  private readonly editor: DraftEditor = new DraftEditor(
    this,
    (selector) => {
      void focusInside(this, selector);
    },
    () => undefined,
  );

  override willUpdate(changed: PropertyValues): void {
    if (this.hasUpdated && !changed.has("rule")) return;
    this.draft = this.rule === null ? NEW_RULE : ruleDraft(this.rule);
    const nowUs = Date.now() * 1000;
    this.editor.open(ruleGroup(this.rule, nowUs), this.zone, nowUs);
  }

  override render(): TemplateResult | typeof nothing {
    const view = this.formView();
    if (view === null) return nothing;
    const read = readRule(this.draft, view.readRequest);
    return html`<form class="sheet" novalidate @submit=${this.onSubmit} @input=${this.onInput}>
      <h2>${this.rule === null ? msg("New rule") : msg(str`Change rule ${this.rule.name}`)}</h2>
      ${this.renderFilter(read)} ${this.renderAsked(read)} ${renderFrames(view, this.editor)} ${renderConstraints(view)}
      <section aria-labelledby="would">
        <h3 id="would">${msg("What it would have made of the last notices")}</h3>
        <t-alert-rule-preview .site=${this.site} .proposal=${this.proposal?.id ?? ""} .asked=${read.asked} .zone=${this.zone}></t-alert-rule-preview>
      </section>
      ${this.tried && read.asked === null ? html`<p role="alert">${msg("Not kept yet:")} ${[...read.problems.values(), ...view.readRequest.problems.values()].slice(0, 3).join(" ")}</p>` : nothing}
      ${renderAdvice(this.action.problem)}
      <div class="actions">
        <t-button type="submit" kind="primary" ?busy=${this.action.busy}>${msg("Keep")}</t-button>
        <t-button @click=${this.onCancel}>${msg("Cancel")}</t-button>
      </div>
    </form>`;
  }

  private formView(): FormView | null {
    const { draft, at, request, opened } = this.editor;
    const read = readGroup(draft, { momentOf: this.editor.momentOf, nowUs: 0, abilities: this.abilities });
    const readRequest = read.requests[at];
    if (request === undefined || readRequest === undefined) return null;
    return { draft, read, at, request, readRequest, proposals: [], abilities: this.abilities, zone: this.zone, tried: this.tried, opened };
  }

  private renderFilter(read: ReadRule): TemplateResult {
    const { draft } = this;
    return html`<fieldset>
      <legend>${msg("A notice passes when")}</legend>
      ${this.renderField("sources", msg("It comes from"), read, html`<textarea name="rule.sources" spellcheck="false" .value=${draft.sources}></textarea>`, msg("Patterns, one a line: *SWIFT*; empty: anybody"))}
      ${this.renderField("parameters", msg("Its parameters say"), read, html`<textarea name="rule.parameters" spellcheck="false" .value=${draft.parameters}></textarea>`, msg("One a line: Rate_Signif >= 7, or Packet_Type = 61, 67"))}
      ${this.renderField("largestError", msg("Its place is known to (°)"), read, numberInput("rule.largestError", draft.largestError), msg("or better; empty: any"))}
      ${this.renderField("lowestDec", msg("Lowest declination (°)"), read, numberInput("rule.lowestDec", draft.lowestDec), msg("empty: any"))}
      ${this.renderField("highestDec", msg("Highest declination (°)"), read, numberInput("rule.highestDec", draft.highestDec), msg("empty: any"))}
      <div class="wide" role="group" aria-label=${msg("Its role is")}>
        <span class="small">${msg("Its role is")}</span>
        <div class="actions">${map(ROLES, (role) => html`<label class="tick"><input name="rule.role" type="checkbox" .value=${role} .checked=${draft.roles.includes(role)} /> ${role}</label>`)}</div>
        ${read.problems.has("roles") ? html`<p class="wrong" role="alert">${read.problems.get("roles")}</p>` : nothing}
      </div>
    </fieldset>`;
  }

  private renderAsked(read: ReadRule): TemplateResult {
    const { draft, proposal } = this;
    return html`<fieldset>
      <legend>${msg("Then a rapid request is made")}</legend>
      ${this.renderField("name", msg("Called"), read, html`<input name="rule.name" maxlength="100" autocomplete="off" .value=${settled(draft.name)} />`, msg("With the event's name behind it"))}
      ${this.renderField("hours", msg("Within (h)"), read, numberInput("rule.hours", draft.hours), msg("Of the event; what is older is not asked for"))}
      ${this.renderField("priority", msg("Priority"), read, numberInput("rule.priority", draft.priority), proposal === null ? "" : msg(str`Up to ${String(proposal.max_priority)} in this proposal`))}
      <label class="tick"><input name="rule.active" type="checkbox" .checked=${draft.active} /> ${msg("The rule is active")}</label>
    </fieldset>`;
  }

  private renderField(field: RuleField, label: string, { problems }: ReadRule, control: TemplateResult, hint = ""): TemplateResult {
    const untouched = !this.tried && field === "name" && this.draft.name === "";
    return html`<t-field .label=${label} .hint=${hint} .error=${untouched ? "" : (problems.get(field) ?? "")}>${control}</t-field>`;
  }

  private readonly onInput = (event: Event): void => {
    const field = event.target;
    if (!(field instanceof HTMLInputElement || field instanceof HTMLTextAreaElement || field instanceof HTMLSelectElement)) return;
    const name = OWN_FIELD.exec(field.name)?.[1] ?? "";
    if (name === "") this.editor.onInput(event);
    else if (name === "active" && field instanceof HTMLInputElement) this.draft = { ...this.draft, active: field.checked };
    else if (name === "role" && field instanceof HTMLInputElement) this.draft = { ...this.draft, roles: ROLES.filter((role) => (role === field.value ? field.checked : this.draft.roles.includes(role))) };
    else if (name in this.draft) this.draft = { ...this.draft, [name]: field.value };
  };

  private readonly onSubmit = (event: Event): void => {
    event.preventDefault();
    this.tried = true;
    const { asked } = readRule(this.draft, this.formView()?.readRequest);
    const { rule, proposal } = this;
    if (asked === null || proposal === null) return;
    const api = new AlertRulesApi(this.api, this.site, proposal.id);
    void this.action.run(msg("keep the rule"), () => (rule === null ? api.addRule(asked) : api.changeRule(rule.id, asked))).then((done) => {
      if (done) this.dispatchEvent(new CustomEvent("t-saved"));
    });
  };

  private readonly onCancel = (): void => {
    this.dispatchEvent(new CustomEvent("t-cancel"));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-alert-rule-form": AlertRuleForm;
  }
}
