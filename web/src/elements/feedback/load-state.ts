/** What a page shows of a request: its failure with what to do, or that it is still under way. */

import { html, nothing, type TemplateResult } from "lit";
import type { Loaded } from "../../controllers/load.js";
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
    : html`<t-problem what=${advice.what} how=${advice.how} retry="Try again" @t-retry=${retry}></t-problem>`;
}

/** @param asked what was asked for, as the object of a sentence: `the list of sites` */
export function renderLoadError(
  result: Loaded<unknown>,
  asked: string,
  retry?: () => void,
): TemplateResult | typeof nothing {
  return result.state === "failed" ? renderAdvice(adviceFor(result.error, asked), retry) : nothing;
}

/** Stands where a first answer is awaited; nothing once it has failed. */
export function renderLoadingNote(result: Loaded<unknown>, what: string): TemplateResult | typeof nothing {
  return result.state === "failed" ? nothing : html`<t-loading what=${what}></t-loading>`;
}
