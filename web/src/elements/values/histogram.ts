import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, svg, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { roundText } from "../../format/number.js";
import { base, quietText } from "../base/base-style.js";

/** How many pixels have which value: bars of equal width, their heights as a logarithm. */
@customElement("t-histogram")
export class Histogram extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-1);
      }
      svg {
        display: block;
        inline-size: 100%;
        block-size: 6rem;
        border-block-end: 1px solid var(--t-edge);
        color: var(--t-accent);
      }
      .ends {
        display: flex;
        justify-content: space-between;
        ${quietText}
        font-variant-numeric: tabular-nums;
      }
    `,
  ];

  @property({ attribute: false }) counts: readonly number[] = [];
  /** Value at the left edge. */
  @property({ type: Number }) low = Number.NaN;
  /** Value at the right edge. */
  @property({ type: Number }) high = Number.NaN;

  override render(): TemplateResult {
    const most = Math.log1p(Math.max(1, ...this.counts));
    const wide = 100 / Math.max(1, this.counts.length);
    const bars = this.counts.map((count, at) => {
      const tall = (100 * Math.log1p(count)) / most;
      return svg`<rect x=${at * wide} y=${100 - tall} width=${wide * 0.9} height=${tall} fill="currentColor"></rect>`;
    });
    return html`<svg viewBox="0 0 100 100" preserveAspectRatio="none" role="img" aria-label=${this.describeBars()}>
        ${bars}
      </svg>
      ${Number.isNaN(this.low) ? nothing : html`<div class="ends"><span>${round(this.low)}</span><span>${round(this.high)}</span></div>`}`;
  }

  private describeBars(): string {
    return msg(str`Histogram of the pixel values from ${round(this.low)} to ${round(this.high)}`);
  }
}

function round(value: number): string {
  return Number.isNaN(value) ? "–" : roundText(value, 5);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-histogram": Histogram;
  }
}
