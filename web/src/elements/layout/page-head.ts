/** The head of a page or of a section of it: its title, what it is about, and what can be done there. */

import { html, nothing, type TemplateResult } from "lit";

/**
 * Drawn with `sheets`.
 *
 * @param lead a sentence below the title
 * @param actions buttons or links beside it
 */
export function renderPageHead(title: string, lead: unknown = nothing, actions: unknown = nothing): TemplateResult {
  return html`<div class="head">
    <div>
      <h1>${title}</h1>
      ${lead === nothing ? nothing : html`<p class="muted">${lead}</p>`}
    </div>
    ${actions}
  </div>`;
}
