/** A list of rows, as every page shows one; drawn with `sheets`. */

import { html, type TemplateResult } from "lit";
import { repeat } from "lit/directives/repeat.js";

/** @param renderRow draws a row as an `<li>` */
export function renderRows<R extends { readonly id: string }>(rows: readonly R[], renderRow: (row: R) => TemplateResult): TemplateResult {
  return html`<ul class="rows">
    ${repeat(rows, ({ id }) => id, renderRow)}
  </ul>`;
}

/**
 * The same on a sheet of its own.
 *
 * @param label its name for who hears the page
 * @param busy more rows are on their way
 */
export function renderRowSheet<R extends { readonly id: string }>(label: string, rows: readonly R[], renderRow: (row: R) => TemplateResult, busy = false): TemplateResult {
  return html`<section class="sheet" aria-label=${label} aria-busy=${busy}>${renderRows(rows, renderRow)}</section>`;
}
