/** An endless list as a page shows it, with what stands below: that more is coming, that it did not come, or that there is none. */

import { msg, str } from "@lit/localize";
import { html, nothing, type TemplateResult } from "lit";
import type { InfiniteRows, IdentifiedRow } from "../controllers/infinite-rows.js";
import { renderRowSheet } from "../elements/layout/rows.js";
import { adviceFor } from "../format/error-advice.js";
import { renderAdvice } from "../elements/feedback/load-state.js";
import "../elements/feedback/loading.js";

/** The words about a list, and what it is made of. */
interface InfiniteListOptions<R> {
  /** Of its sheet, for who hears the page. */
  readonly label: string;
  /** What it is a list of, as the object of a sentence: `the logbook`. */
  readonly what: string;
  /** One row, as an `<li>`. */
  readonly row: (row: R) => TemplateResult;
  /** What is shown when it has no rows. */
  readonly nothing: () => TemplateResult;
}

export function renderInfiniteList<R extends IdentifiedRow>(list: InfiniteRows<R>, { label, what, row, nothing: none }: InfiniteListOptions<R>): TemplateResult {
  const { rows, hasMore: more, loading } = list;
  return html`${rows.length === 0 && !more ? none() : nothing}
    ${rows.length === 0
      ? nothing
      : renderRowSheet(label, rows, row, loading)}
    ${renderListEnd(list, what)}`;
}

function renderListEnd<R extends IdentifiedRow>(list: InfiniteRows<R>, what: string): TemplateResult {
  const advice = list.renderFailure === null ? null : adviceFor(list.renderFailure, what);
  return html`${advice === null
      ? nothing
      : renderAdvice(advice, list.retry)}
    ${list.loading || !list.hasStarted ? html`<t-loading what=${msg(str`Loading ${what}`)}></t-loading>` : nothing}
    <p class="end">${list.hasMore || list.rows.length === 0 ? "" : msg("This is where it begins.")}</p>`;
}
