/** How an alarm would have done over a stretch of the past, beside how it would have as it was set before. */

import { msg, str } from "@lit/localize";
import { css, html, nothing, type TemplateResult } from "lit";
import { map } from "lit/directives/map.js";
import { styled } from "../../elements/base/style-directive.js";
import { formatDuration } from "../../format/duration.js";
import { plural } from "../../words/plural.js";
import type { PreviewShape } from "../../generated/api.js";
import type { SelectOption } from "../../elements/forms/form-parts.js";
import "../../elements/feedback/problem.js";
import "../../elements/values/time.js";

const MOST_SPANS = 8;

/** Hours that can be looked back, as the choice has them. */
export const trialWindows = (): readonly SelectOption[] => [
  ["24", msg("the last day")],
  ["168", msg("the last week")],
  ["720", msg("the last 30 days")],
];

export const trialStyle = css`
  .trials {
    display: grid;
    grid-template-columns: repeat(auto-fit, minmax(min(100%, 18rem), 1fr));
    gap: var(--t-space-4);
  }
  .strip {
    position: relative;
    block-size: 1.75rem;
    border: 1px solid var(--t-line);
    border-radius: var(--t-radius-s);
    background: var(--t-raised);
    overflow: hidden;
  }
  .strip span {
    position: absolute;
    inset-block: 0;
    min-inline-size: 2px;
    background: var(--t-bad);
  }
  ul {
    margin: 0;
    padding-inline-start: var(--t-space-4);
    font-size: var(--t-size-s);
  }
`;

/** @param before of other settings, over the same stretch; null: there are none */
export function renderTrials(now: PreviewShape | null, before: PreviewShape | null, zone: string): unknown {
  if (now !== null && (now.problem ?? "") !== "") {
    return html`<t-problem what=${msg("It cannot be tried.")} how=${now.problem ?? ""}></t-problem>`;
  }
  if (now === null && before === null) return nothing;
  return html`<div class="trials">
    ${now === null ? nothing : renderTrial(now, zone, msg("As it is set now"))}${before === null ? nothing : renderTrial(before, zone, msg("As it was set before"))}
  </div>`;
}

function renderTrial(said: PreviewShape, zone: string, heading: string): TemplateResult {
  const from = said.from_us ?? 0;
  const length = Math.max(1, (said.to_us ?? 0) - from);
  const spans = said.spans ?? [];
  const count = said.count ?? 0;
  const unknown = (said.unknown_us ?? 0) / 1e6;
  return html`<section aria-label=${heading} role="status">
    <h3>${heading}</h3>
    <p>
      ${plural(count, msg("It would have been raised once."), msg(str`It would have been raised ${String(count)} times.`))}
      ${unknown < 1 ? nothing : msg(str`It could not have been judged for ${formatDuration(Math.round(unknown))}.`)}
    </p>
    <div class="strip" aria-hidden="true">
      ${map(
        spans,
        (span) =>
          html`<span ${styled({ "inset-inline-start": percent((span.from_us - from) / length), "inline-size": percent((span.to_us - span.from_us) / length) })}></span>`,
      )}
    </div>
    <ul>
      ${map(
        spans.slice(-MOST_SPANS),
        (span) => html`<li>
          ${msg(html`<t-time .us=${span.from_us} .zone=${zone}></t-time> for ${formatDuration(Math.round((span.to_us - span.from_us) / 1e6))}:`)} ${span.why}
        </li>`,
      )}
    </ul>
  </section>`;
}

function percent(part: number): string {
  return `${(100 * part).toFixed(3)}%`;
}
