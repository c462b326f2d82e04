/** One back-test: how far it is, what it costs, and what the detector would have said. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, svg, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base, plainList, quietText } from "../../elements/base/base-style.js";
import { formatDuration } from "../../format/duration.js";
import { formatNumber } from "../../format/number.js";
import { plural } from "../../words/plural.js";
import { sitePath } from "../../state/router.js";
import type { BackTestShape, PastAnomalyShape } from "../../generated/api.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/values/time.js";

/** So many of the anomalies are listed; the strip shows all. */
const LISTED = 10;
const HIGH = 40;

/** @fires t-cancel-test the person ends the test; detail is its key */
@customElement("t-test-result")
export class TestResult extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        align-content: start;
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
      .head {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2) var(--t-space-3);
      }
      h3 {
        font-size: var(--t-size-m);
      }
      progress {
        inline-size: 100%;
        accent-color: var(--t-accent);
      }
      svg {
        inline-size: 100%;
        block-size: 3rem;
        background: var(--t-surface);
        border: 1px solid var(--t-line);
      }
      .score {
        fill: var(--t-accent);
      }
      .score.high {
        fill: var(--t-warn);
      }
      .bar {
        stroke: var(--t-muted);
        stroke-dasharray: 4 3;
      }
      ul {
        display: grid;
        gap: var(--t-space-2);
        ${plainList}
      }
      .quiet {
        ${quietText}
        overflow-wrap: anywhere;
      }
    `,
  ];

  @property() heading = "";
  @property() site = "";
  @property() zone = "UTC";
  @property({ attribute: false }) test: BackTestShape | null = null;

  override render(): TemplateResult | typeof nothing {
    const { test } = this;
    if (test === null) return nothing;
    const { state, count, cpu_s, progress, problem, bar } = test;
    const told = plural(count, msg("1 anomaly"), msg(str`${String(count)} anomalies`));
    const cost = formatNumber(cpu_s, 1);
    return html`<div class="head">
        <h3>${this.heading}</h3>
        ${renderState(test)}
        ${state === "running" ? html`<t-button kind="quiet" label=${msg(str`Cancel ${this.heading}`)} @click=${this.cancel}>${msg("Cancel")}</t-button>` : nothing}
      </div>
      ${state === "running" ? html`<progress max="1" .value=${progress} aria-label=${msg(str`${this.heading}: how much is done`)}></progress>` : nothing}
      <p role="status">
        ${state === "done"
          ? msg(html`It would have told of <strong>${told}</strong>, told from ${formatNumber(bar, 2)}. Cost: ${cost} s of a core.`)
          : state === "running"
            ? msg(html`Up to now <strong>${told}</strong>, told from ${formatNumber(bar, 2)}. Cost: ${cost} s of a core, ${formatNumber(progress * 100, 0)} % done.`)
            : msg(html`Up to now <strong>${told}</strong>, told from ${formatNumber(bar, 2)}. Cost: ${cost} s of a core.`)}
      </p>
      ${problem === "" ? nothing : html`<p class="quiet">${problem}</p>`} ${renderShort(test)} ${renderStrip(test)}
      <ul>
        ${map(test.anomalies.slice(0, LISTED), (anomaly) => this.renderAnomaly(anomaly))}
      </ul>
      ${count > LISTED ? html`<p class="quiet">${msg(str`And ${String(count - LISTED)} more.`)}</p>` : nothing}`;
  }

  private renderAnomaly({ from_us, to_us, why }: PastAnomalyShape): TemplateResult {
    const around = new URLSearchParams({ from: String(from_us - 300e6), to: String(to_us + 300e6) });
    return html`<li>
      <a href=${`${sitePath(this.site, "history")}?${around.toString()}`}><t-time .us=${from_us} .zone=${this.zone}></t-time></a>
      ${msg(str`for ${formatDuration(Math.max(1, Math.round((to_us - from_us) / 1e6)))}`)}<br /><span class="quiet">${why}</span>
    </li>`;
  }

  private readonly cancel = (): void => {
    this.dispatchEvent(new CustomEvent("t-cancel-test", { detail: this.test?.key ?? "", bubbles: true, composed: true }));
  };
}

function renderState({ state }: BackTestShape): TemplateResult {
  switch (state) {
    case "running":
      return html`<t-status kind="busy" word=${msg("computing")}></t-status>`;
    case "done":
      return html`<t-status kind="ok" word=${msg("done")}></t-status>`;
    case "cancelled":
      return html`<t-status kind="unknown" word=${msg("cancelled")}></t-status>`;
    case "failed":
      return html`<t-status kind="error" word=${msg("failed")}></t-status>`;
  }
}

function renderShort({ rows, learning, state }: BackTestShape): unknown {
  if (state === "done" && rows === 0) return html`<p class="quiet">${msg("There is no history of it in this window.")}</p>`;
  if (learning === 0) return nothing;
  return html`<p class="quiet">${msg(str`There was too little history before the window: it learned for ${formatNumber(learning, 0)} more samples of it, and told little of these.`)}</p>`;
}

/** The greatest score of each part of the window. */
function renderStrip({ scores, bar }: BackTestShape): TemplateResult {
  const at = String(HIGH * (1 - bar));
  return html`<svg viewBox=${`0 0 ${String(scores.length)} ${String(HIGH)}`} preserveAspectRatio="none" role="img" aria-label=${msg("The greatest scores over the window")}>
    ${map(scores, (score, place) => renderPart(score, place, bar))}
    <line class="bar" x1="0" x2=${String(scores.length)} y1=${at} y2=${at} vector-effect="non-scaling-stroke"></line>
  </svg>`;
}

function renderPart(score: number, place: number, bar: number): unknown {
  if (score <= 0) return nothing;
  const high = HIGH * score;
  return svg`<rect class=${score >= bar ? "score high" : "score"} x=${String(place)} width="1" y=${String(HIGH - high)} height=${String(high)}></rect>`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-test-result": TestResult;
  }
  interface HTMLElementEventMap {
    "t-cancel-test": CustomEvent<string>;
  }
}
