/** Of which alarms a person wants to be told, by which way and when not: a new rule, or one that is changed. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import { focusInside } from "../../elements/base/focus.js";
import { renderFormActions, renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { submittedForm } from "../../format/form-values.js";
import type { Advice } from "../../format/error-advice.js";
import type { NoticeRuleShape, RuleAsk, SiteSummary, WayChoice } from "../../generated/api.js";
import { ruleFromForm, FIRST, quietHours, SEVERITIES } from "./notification-rule.js";
import "../../elements/forms/field.js";

/**
 * @fires t-rule detail is the rule that is asked for
 * @fires t-cancel
 */
@customElement("t-rule-form")
export class NotificationRuleForm extends LitElement {
  static override styles = [
    base,
    sheets,
    forms,
    css`
      @media (min-width: 45rem) {
        label.tick {
          /* Beside the boxes of the fields, not beside their names. */
          margin-block-start: 1.4rem;
        }
      }
    `,
  ];

  /** Null for a new one. */
  @property({ attribute: false }) rule: NoticeRuleShape | null = null;
  @property({ attribute: false }) ways: readonly WayChoice[] = [];
  @property({ attribute: false }) sites: readonly SiteSummary[] = [];
  @property({ attribute: false }) problem: Advice | null = null;
  @property({ type: Boolean }) busy = false;
  /** The way that is chosen; empty before one was. */
  @state() private way = "";

  override firstUpdated(): void {
    void focusInside(this, "select");
  }

  override render(): TemplateResult {
    const rule = { ...FIRST, ...this.rule };
    const chosen = this.way || this.rule?.way;
    const way = this.ways.find(({ id }) => id === chosen) ?? this.ways[0];
    const quiet = quietHours(rule);
    return html`<form class="entry" novalidate @submit=${this.onSubmit}>
      <t-field label=${msg("By")}>
        <select name="way" @change=${this.onChoose}>
          ${renderOptions(this.ways.map(({ id, name }) => [id, name]), way?.id ?? "")}
        </select>
      </t-field>
      ${way?.kind === "mail"
        ? html`<t-field label=${msg("Mail address")}><input name="target" type="email" maxlength="200" autocomplete="email" .value=${rule.target} /></t-field>`
        : nothing}
      <t-field label=${msg("Of")}>
        <select name="site">
          ${renderOptions([["*", msg("every site")], ...this.places(rule.site).map(({ site, name }) => [site, name] as const)], rule.site)}
        </select>
      </t-field>
      <t-field label=${msg("At least")}>
        <select name="least">${renderOptions(SEVERITIES, rule.least)}</select>
      </t-field>
      <t-field label=${msg("Quiet from")} hint=${msg("Empty: never quiet")}><input name="from" type="time" .value=${quiet?.from ?? ""} /></t-field>
      <t-field label=${msg("Quiet until")} hint=${msg("Alarms in that time are notified when it ends")}><input name="to" type="time" .value=${quiet?.to ?? ""} /></t-field>
      ${this.renderClock()}
      <t-field label=${msg("Notify in quiet hours too")}>
        <select name="quiet_least">${renderOptions(SEVERITIES.slice(1), rule.quiet_least)}</select>
      </t-field>
      <t-field label=${msg("Gathered for (s)")} hint=${msg("A burst comes as one message")}><input name="group_s" inputmode="numeric" .value=${String(rule.group_s)} /></t-field>
      <label class="tick"><input name="over" type="checkbox" .checked=${rule.over} /> ${msg("Also when it is over")}</label>
      <label class="tick">
        <input name="own_requests" type="checkbox" .checked=${rule.own_requests} /> ${msg("Also when a request of yours is done, or has failed")}
      </label>
      <label class="tick">
        <input name="nights" type="checkbox" .checked=${rule.nights} /> ${msg("Also how a night that runs by itself has ended, and when it needs somebody")}
      </label>
      ${renderFormActions({ submit: this.rule === null ? msg("Notify me") : msg("Save"), busy: this.busy, cancel: this.onCancel })}
      ${renderAdvice(this.problem)}
    </form>`;
  }

  /** The quiet hours are by the clock at which they were chosen; elsewhere one says by which. */
  private renderClock(): TemplateResult {
    const here = Intl.DateTimeFormat().resolvedOptions().timeZone;
    const zone = this.rule?.zone ?? here;
    if (zone === here) return html`<input type="hidden" name="zone" .value=${here} />`;
    return html`<t-field label=${msg("By the clock of")}>
      <select name="zone">${renderOptions([zone, here], zone)}</select>
    </t-field>`;
  }

  /** The sites to choose from, and the one that was chosen when it could be seen. */
  private places(chosen: string): readonly { readonly site: string; readonly name: string }[] {
    const there = chosen === "*" || this.sites.some(({ site }) => site === chosen);
    return there ? this.sites : [...this.sites, { site: chosen, name: chosen }];
  }

  private readonly onChoose = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.way = event.target.value;
  };

  private readonly onCancel = (): void => {
    this.dispatchEvent(new CustomEvent("t-cancel"));
  };

  private readonly onSubmit = (event: Event): void => {
    const data = submittedForm(event);
    if (data !== undefined && !this.busy) this.dispatchEvent(new CustomEvent<RuleAsk>("t-rule", { detail: ruleFromForm(data) }));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-rule-form": NotificationRuleForm;
  }
  interface GlobalEventHandlersEventMap {
    "t-rule": CustomEvent<RuleAsk>;
  }
}
