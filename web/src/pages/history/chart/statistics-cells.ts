/** The statistics of one channel over the shown window, as cells of a chart's table. */

import { html, nothing, type TemplateResult } from "lit";
import { decimalsFor, formatNumber, NOTHING } from "../../../format/number.js";
import type { Summary } from "../../../series/columns.js";
import type { StatisticsInfo } from "../../../wire/api-types.js";
import type { Row } from "../data/channel-rows.js";

export function renderStatisticsHead(numbers: boolean): TemplateResult {
  return html`${numbers
      ? html`<th scope="col">min</th>
          <th scope="col">mean</th>
          <th scope="col">max</th>
          <th scope="col" class="roomy" title="Standard deviation">std</th>`
      : nothing}
    <th scope="col" class="roomy">samples</th>`;
}

/**
 * @param counted what the hub counted; undefined until it has, while the window moves
 * @param drawn what is drawn: its least and greatest are those of all samples, its mean is not
 */
export function renderStatisticsCells(row: Row, counted: StatisticsInfo | undefined, drawn: Summary | undefined): TemplateResult {
  const samples = html`<td class="roomy">${counted === undefined ? "…" : formatNumber(counted.count, 0)}</td>`;
  if (row.type !== "number") return samples;
  const decimals = decimalsFor(row.unit, row.decimals);
  const text = (value: number | null | undefined): string => (value === null || value === undefined ? NOTHING : formatNumber(value, decimals));
  const [min, max] = counted === undefined ? known(drawn) : [counted.low?.v, counted.high?.v];
  const only = (value: number | null | undefined): string => (counted === undefined ? "…" : text(value));
  return html`<td>${text(min)}</td>
    <td>${only(counted?.mean)}</td>
    <td>${text(max)}</td>
    <td class="roomy">${only(counted?.deviation)}</td>
    ${samples}`;
}

function known(drawn: Summary | undefined): [number | null, number | null] {
  return drawn === undefined || drawn.count === 0 ? [null, null] : [drawn.min, drawn.max];
}
