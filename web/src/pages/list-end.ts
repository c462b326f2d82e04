/** What stands below an endless list: that more is coming, that it did not come, or that there is none. */

import { html, nothing, type TemplateResult } from "lit";
import type { EndlessRows, Row } from "../controllers/endless-rows.js";
import { adviceFor } from "../format/problem.js";
import "../elements/loading.js";
import "../elements/problem.js";

/** @param what it is a list of, as the object of a sentence: `the logbook` */
export function listEnd<R extends Row>(list: EndlessRows<R>, what: string): TemplateResult {
  const advice = list.failure === null ? null : adviceFor(list.failure, what);
  return html`${advice === null
      ? nothing
      : html`<t-problem what=${advice.what} how=${advice.how} retry="Try again" @t-retry=${list.again}></t-problem>`}
    ${list.loading || !list.asked ? html`<t-loading what=${`Loading ${what}`}></t-loading>` : nothing}
    <p class="end">${list.more || list.rows.length === 0 ? "" : "This is where it begins."}</p>`;
}
