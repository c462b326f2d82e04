/** Sentences of the history page: that nothing is chosen, and what lies behind. */

import { msg, str } from "@lit/localize";
import { html, type TemplateResult } from "lit";
import { formatDate, timeText } from "../../format/time.js";
import type { TimeSpan } from "../../series/time-window.js";
import type { ChannelRow } from "./data/channel-rows.js";
import { comparedDaysText, type HistoryView } from "./history-query.js";
import "../../elements/feedback/empty.js";
import "../../elements/forms/button.js";

/** What the dashed lines are, and how to be without them. @param ghostUs how much before the window it lies (µs) */
export function renderCompared(span: TimeSpan, ghostUs: number, { versus, shiftUs }: Pick<HistoryView, "versus" | "shiftUs">, zone: string, end: () => void): TemplateResult {
  const began = span.fromUs - ghostUs;
  const words = shiftUs === 0 ? msg(str`${formatDate(began, zone)}, ${comparedDaysText(versus)}, at the same time of day`) : msg(str`the run of ${timeText(began, zone, 0).local}, laid over this one`);
  return html`<p class="then">${msg(str`Dashed lines: ${words}.`)} <t-button kind="quiet" @click=${end}>${msg("End the comparison")}</t-button></p>`;
}

export function renderNothingChosen(rows: readonly ChannelRow[]): TemplateResult {
  return rows.length === 0
    ? html`<t-empty heading=${msg("Nothing to show")} icon="history"><p>${msg("This site has no signals that you may see.")}</p></t-empty>`
    : html`<t-empty heading=${msg("Choose a signal")} icon="history"
        ><p>${msg("Tick what you want to see under “Signals”. Signals of one unit share a chart.")}</p></t-empty
      >`;
}
