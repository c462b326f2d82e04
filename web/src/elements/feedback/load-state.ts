/** What a page shows of a request: its failure with what to do, or that it is still under way. */

import { msg, str } from "@lit/localize";
import { html, nothing, type TemplateResult } from "lit";
import type { LoadController } from "../../controllers/load.js";
import { adviceFor, type Advice } from "../../format/error-advice.js";
import "./loading.js";
import "./problem.js";

/** Nothing without advice; with `retry` a button to try again. */
export function renderAdvice(advice: Advice, retry?: () => void): TemplateResult;
export function renderAdvice(advice: Advice | null, retry?: () => void): TemplateResult | typeof nothing;
export function renderAdvice(advice: Advice | null, retry?: () => void): TemplateResult | typeof nothing {
  if (advice === null) return nothing;
  return retry === undefined
    ? html`<t-problem what=${advice.what} how=${advice.how}></t-problem>`
    : html`<t-problem what=${advice.what} how=${advice.how} retry=${msg("Try again")} @t-retry=${retry}></t-problem>`;
}

/**
 * What was loaded, drawn by `view`; its failure with a way to try again; before either, that it is on its way.
 *
 * @param what is loaded, as the object of a sentence: `the list of sites`
 */
export function renderLoaded<T>(load: LoadController<T>, what: string, view: (value: T) => unknown): unknown {
  const { result, value } = load;
  if (result.state === "failed") return renderAdvice(adviceFor(result.error, what), load.invalidate);
  return value === undefined ? html`<t-loading what=${msg(str`Loading ${what}`)}></t-loading>` : view(value);
}
