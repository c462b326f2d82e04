/** What of the audit log to show. */

import { msg, str } from "@lit/localize";
import { html, LitElement, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { FilterForm } from "../../controllers/filter-form.js";
import { base } from "../../elements/base/base-style.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { knownZone } from "../../format/time.js";
import { formTexts } from "../../format/filter-query.js";
import { formText } from "../../format/form-values.js";
import { momentProblem, ZoneClock } from "../../series/zone-clock.js";
import type { SiteSummary } from "../../generated/api.js";
import { FILTER_KEYS, NO_FILTER, writeAuditFilter, type AuditFilter } from "./audit-query.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

/** @fires t-filter detail is the new one */
@customElement("t-audit-filter")
export class AuditFilterForm extends LitElement {
  static override styles = [base, sheets, forms];

  @property({ attribute: false }) filter: AuditFilter = NO_FILTER;
  @property({ attribute: false }) sites: readonly SiteSummary[] = [];
  @property() zone = "UTC";

  /** What is written as a time and is none, by field: nothing is filtered by it. */
  @state() private wrongTimes: Readonly<Record<string, string>> = {};

  private readonly form = new FilterForm<AuditFilter>(
    this,
    (said) => this.readFilter(said),
    (detail) => {
      if (detail === NO_FILTER) this.wrongTimes = {};
      this.dispatchEvent(new CustomEvent("t-filter", { detail }));
    },
    NO_FILTER,
  );

  override render(): TemplateResult {
    const { filter } = this;
    const clock = new ZoneClock(knownZone(this.zone));
    const shown = (us: number): string => (Number.isNaN(us) ? "" : clock.toInput(us));
    return html`<form class="filter" @submit=${this.form.onSubmit} @change=${this.form.onSubmit}>
      <t-field label=${msg("Person")}><input name="who" autocomplete="off" maxlength="200" .value=${filter.who} /></t-field>
      <t-field label=${msg("Site")}>
        <select name="site">
          ${renderOptions([["", msg("all", { id: "all.sites" })], ...this.sites.map(({ site, name }) => [site, name] as const)], filter.site)}
        </select>
      </t-field>
      <t-field label=${msg("Device")}><input name="device" autocomplete="off" maxlength="200" .value=${filter.device} /></t-field>
      <t-field label=${msg("Kind")} hint=""><input name="kind" autocomplete="off" maxlength="200" .value=${filter.kind} /></t-field>
      <t-field label=${msg("Outcome")}>
        <select name="good">
          ${renderOptions([["", msg("both")], ["true", msg("done", { id: "done.outcome" })], ["false", msg("refused", { id: "refused.outcome" })]], filter.good)}
        </select>
      </t-field>
      <t-field class="time" label=${msg(str`From (${clock.zone})`)} .error=${momentProblem(this.wrongTimes["from"] ?? "", Number.NaN)}>
        <input name="from" type="text" autocomplete="off" placeholder="2026-03-29 14:05:09" maxlength="30" .value=${this.wrongTimes["from"] ?? shown(filter.fromUs)} />
      </t-field>
      <t-field class="time" label=${msg(str`To (${clock.zone})`)} .error=${momentProblem(this.wrongTimes["to"] ?? "", Number.NaN)}>
        <input name="to" type="text" autocomplete="off" placeholder="2026-03-29 14:05:09" maxlength="30" .value=${this.wrongTimes["to"] ?? shown(filter.toUs)} />
      </t-field>
      <div class="actions">
        <t-button type="submit">${msg("Show")}</t-button>
        <t-button kind="quiet" ?disabled=${writeAuditFilter(filter) === ""} @click=${this.form.clearFilter}>${msg("Clear")}</t-button>
      </div>
    </form>`;
  }

  private readFilter(said: FormData): AuditFilter {
    const clock = new ZoneClock(knownZone(this.zone));
    const good = formText(said, "good");
    const [from, to] = ["from", "to"].map((name) => formText(said, name)) as [string, string];
    const [fromUs, toUs] = [clock.fromInput(from), clock.fromInput(to)];
    this.wrongTimes = {
      ...(momentProblem(from, fromUs) === "" ? {} : { from }),
      ...(momentProblem(to, toUs) === "" ? {} : { to }),
    };
    return { ...formTexts(said, FILTER_KEYS), good: good === "true" || good === "false" ? good : "", fromUs, toUs };
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-audit-filter": AuditFilterForm;
  }
  interface GlobalEventHandlersEventMap {
    "t-filter": CustomEvent<AuditFilter>;
  }
}
