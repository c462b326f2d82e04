/** What of the audit log to show. */

import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base } from "../../elements/base.js";
import { sheets } from "../../elements/sheets.js";
import { knownZone } from "../../format/time.js";
import { ZoneClock } from "../../series/zone.js";
import type { SiteRow } from "../../wire/api.js";
import { NO_FILTER, writeFilter, type AuditFilter } from "./query.js";
import "../../elements/button.js";
import "../../elements/field.js";

/** @fires t-filter detail is the new one */
@customElement("t-audit-filter")
export class AuditFilterForm extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      form {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(9.5rem, 100%), 1fr));
        align-items: end;
        gap: var(--t-space-3);
      }
      .time,
      .actions {
        grid-column: span 2;
      }
      @media (max-width: 45rem) {
        form {
          grid-template-columns: 1fr 1fr;
        }
        .time,
        .actions {
          grid-column: 1 / -1;
        }
      }
    `,
  ];

  @property({ attribute: false }) filter: AuditFilter = NO_FILTER;
  @property({ attribute: false }) sites: readonly SiteRow[] = [];
  @property() zone = "UTC";
  @query("form") private readonly form!: HTMLFormElement;

  override render(): TemplateResult {
    const { filter } = this;
    const clock = new ZoneClock(knownZone(this.zone));
    const shown = (us: number): string => (Number.isNaN(us) ? "" : clock.toInput(us));
    return html`<form @submit=${this.submit} @change=${this.changed}>
      <t-field label="Person"><input name="who" autocomplete="off" maxlength="200" .value=${filter.who} /></t-field>
      <t-field label="Site">
        <select name="site">
          <option value="">all</option>
          ${map(
            this.sites,
            ({ site, name }) => html`<option value=${site} .selected=${site === filter.site}>${name}</option>`,
          )}
        </select>
      </t-field>
      <t-field label="Device"><input name="device" autocomplete="off" maxlength="200" .value=${filter.device} /></t-field>
      <t-field label="Kind" hint=""><input name="kind" autocomplete="off" maxlength="200" .value=${filter.kind} /></t-field>
      <t-field label="Outcome">
        <select name="good">
          <option value="">both</option>
          <option value="true" .selected=${filter.good === "true"}>done</option>
          <option value="false" .selected=${filter.good === "false"}>refused</option>
        </select>
      </t-field>
      <t-field class="time" label=${`From (${clock.zone})`}>
        <input name="from" type="datetime-local" step="1" .value=${shown(filter.fromUs)} />
      </t-field>
      <t-field class="time" label=${`To (${clock.zone})`}>
        <input name="to" type="datetime-local" step="1" .value=${shown(filter.toUs)} />
      </t-field>
      <div class="actions">
        <t-button type="submit">Show</t-button>
        <t-button kind="quiet" ?disabled=${writeFilter(filter) === ""} @click=${this.clear}>Clear</t-button>
      </div>
    </form>`;
  }

  private readonly submit = (event: SubmitEvent): void => {
    event.preventDefault();
    this.changed();
  };

  private readonly changed = (): void => {
    const typed = new FormData(this.form);
    const text = (key: string): string => {
      const value = typed.get(key);
      return typeof value === "string" ? value.trim() : "";
    };
    const clock = new ZoneClock(knownZone(this.zone));
    const good = text("good");
    this.tell({
      who: text("who"),
      site: text("site"),
      device: text("device"),
      kind: text("kind"),
      good: good === "true" || good === "false" ? good : "",
      fromUs: clock.fromInput(text("from")),
      toUs: clock.fromInput(text("to")),
    });
  };

  private readonly clear = (): void => {
    this.form.reset();
    this.tell(NO_FILTER);
  };

  private tell(detail: AuditFilter): void {
    this.dispatchEvent(new CustomEvent("t-filter", { detail }));
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
