/** How the history page shows what is chosen: units together, another day behind. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { control } from "../../elements/forms/input-style.js";
import { knownZone } from "../../format/time.js";
import type { TimeSpan } from "../../series/time-window.js";
import { DAY_US, clockOf, type ZoneClock } from "../../series/zone-clock.js";
import type { HistoryView } from "./history-query.js";
import "../../elements/forms/button.js";
import "../../elements/analysis/outlier-tool.js";

const DAYS = [
  { days: 1, name: msg("the day before") },
  { days: 7, name: msg("a week before") },
  { days: 28, name: msg("four weeks before") },
] as const;
const OTHER = "other";

/** @fires t-view detail is what of the view is asked to be otherwise */
@customElement("t-view-options")
export class ViewOptionsMenu extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2) var(--t-space-3);
      }
      label {
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-2);
        ${quietText}
        font-weight: var(--t-weight-strong);
      }
    `,
  ];

  @property({ attribute: false }) view: HistoryView | null = null;
  @property({ attribute: false }) span: TimeSpan = { fromUs: 0, toUs: 1 };
  @property() zone = "UTC";

  /** A day of one's own is being chosen. */
  @state() private choosing = false;

  override render(): TemplateResult | null {
    const { view } = this;
    if (view === null) return null;
    const { versus } = view;
    const known = versus === 0 || DAYS.some(({ days }) => days === versus);
    const other = this.choosing || !known;
    return html`
      <t-button pressed=${view.joined ? "true" : "false"} @click=${this.onJoinChange}>${msg("Units in one chart")}</t-button>
      <t-outlier-tool .k=${view.outliers} @t-outliers=${this.onOutliersChange}></t-outlier-tool>
      <label
        >${msg("Compare with")}
        <select @change=${this.onCompareChange}>
          <option value="0" .selected=${versus === 0 && !other}>${msg("nothing")}</option>
          ${map(DAYS, ({ days, name }) => html`<option value=${days} .selected=${days === versus && !other}>${name}</option>`)}
          <option value=${OTHER} .selected=${other}>${msg("another day…")}</option>
        </select>
      </label>
      ${other
        ? html`<input type="date" aria-label=${msg("Day to compare with")} .value=${this.clock().toInput(this.comparedDayUs()).slice(0, 10)} @change=${this.onDateChange} />`
        : nothing}
    `;
  }

  private clock(): ZoneClock {
    return clockOf(knownZone(this.zone));
  }

  private comparedDayUs(): number {
    return this.clock().sameTime(this.span.fromUs, -(this.view?.versus ?? 0));
  }

  private readonly onJoinChange = (): void => {
    this.fireChange({ joined: this.view?.joined !== true });
  };

  private readonly onOutliersChange = (event: CustomEvent<number>): void => {
    this.fireChange({ outliers: event.detail });
  };

  private readonly onCompareChange = (event: Event): void => {
    if (!(event.target instanceof HTMLSelectElement)) return;
    this.choosing = event.target.value === OTHER;
    if (!this.choosing) this.fireChange({ versus: Number(event.target.value) });
  };

  private readonly onDateChange = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    const clock = this.clock();
    // Days are counted at their middle: those on which summer time begins or ends have another length.
    const then = clock.fromInput(`${event.target.value}T12:00:00`);
    const now = clock.fromInput(`${clock.toInput(this.span.fromUs).slice(0, 10)}T12:00:00`);
    if (!Number.isFinite(then)) return;
    this.choosing = false;
    this.fireChange({ versus: Math.round((now - then) / DAY_US) });
  };

  private fireChange(detail: Partial<HistoryView>): void {
    this.dispatchEvent(new CustomEvent("t-view", { detail }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-view-options": ViewOptionsMenu;
  }
  interface HTMLElementEventMap {
    "t-view": CustomEvent<Partial<HistoryView>>;
  }
}
