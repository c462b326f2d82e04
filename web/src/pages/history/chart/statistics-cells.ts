/** The statistics of one channel over the shown window, as cells of a chart's table. */

import { msg } from "@lit/localize";
import { html, nothing, type TemplateResult } from "lit";
import { decimalsFor, formatNumber, NOTHING } from "../../../format/number.js";
import { differenceToShown, limitToShown } from "../../../format/unit.js";
import type { ColumnsSummary } from "../../../series/columns.js";
import type { StatisticsShape } from "../../../generated/api.js";
import type { ChannelRow } from "../data/channel-rows.js";

export function renderStatisticsHead(numbers: boolean): TemplateResult {
  return html`${numbers
      ? html`<th scope="col">min</th>
          <th scope="col">${msg("mean")}</th>
          <th scope="col">${msg("max")}</th>
          <th scope="col" class="roomy" title=${msg("Standard deviation")}>${msg("std")}</th>`
      : nothing}
    <th scope="col" class="roomy">${msg("samples")}</th>`;
}

/**
 * @param counted what the hub counted; undefined until it has, while the window moves
 * @param drawn what is drawn: its least and greatest are those of all samples, its mean is not
 */
export function renderStatisticsCells(row: ChannelRow, counted: StatisticsShape | undefined, drawn: ColumnsSummary | undefined): TemplateResult {
  const samples = html`<td class="roomy">${counted === undefined ? "…" : formatNumber(counted.count, 0)}</td>`;
  if (row.type !== "number") return samples;
  const decimals = decimalsFor(row.unit, row.decimals);
  // The hub counts in the stored unit; what is drawn is in the shown one already.
  const shown = (value: number | null | undefined): number | null => limitToShown(row.shown, value ?? null);
  const numberText = (value: number | null | undefined): string => (value === null || value === undefined ? NOTHING : formatNumber(value, decimals));
  const [min, max] = counted === undefined ? drawnExtremes(drawn) : [shown(counted.low?.v), shown(counted.high?.v)];
  const countedText = (value: number | null | undefined): string => (counted === undefined ? "…" : numberText(value));
  return html`<td>${numberText(min)}</td>
    <td>${countedText(shown(counted?.mean))}</td>
    <td>${numberText(max)}</td>
    <td class="roomy">${countedText(deviationOf(row, counted))}</td>
    ${samples}`;
}

function deviationOf(row: ChannelRow, counted: StatisticsShape | undefined): number | null {
  const deviation = counted?.deviation ?? null;
  return deviation === null ? null : differenceToShown(row.shown, deviation);
}

function drawnExtremes(drawn: ColumnsSummary | undefined): [number | null, number | null] {
  return drawn === undefined || drawn.count === 0 ? [null, null] : [drawn.min, drawn.max];
}
