/** A joint between its ends: where it stands, and whether an end is near. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base, quietText } from "../base/base-style.js";
import { styled } from "../base/style-directive.js";

@customElement("t-joint")
export class JointBar extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr) auto;
        gap: 0 var(--t-space-3);
        font-variant-numeric: tabular-nums;
      }
      .value {
        font-weight: var(--t-weight-strong);
        text-align: end;
      }
      .near {
        color: var(--t-warn);
      }
      .old {
        color: var(--t-stale);
        font-weight: var(--t-weight);
      }
      .way {
        grid-column: 1 / -1;
        position: relative;
        block-size: 0.75rem;
        border: 1px solid var(--t-edge);
        border-radius: 0.375rem;
        background: var(--t-raised);
      }
      .old + .way {
        border-style: dashed;
      }
      .here {
        position: absolute;
        inset-block: -0.2rem;
        inline-size: 0.35rem;
        margin-inline-start: -0.175rem;
        border-radius: 0.175rem;
        background: var(--t-accent);
      }
      .near + .way .here {
        background: var(--t-warn);
      }
      .end {
        ${quietText}
      }
      .end:last-child {
        text-align: end;
      }
    `,
  ];

  @property() name = "";
  /** As it is shown, with its unit; empty where it is not known now. */
  @property() value = "";
  @property() low = "";
  @property() high = "";
  /** From its lower end, 0 to 1; NaN: not known. */
  @property({ type: Number }) share = Number.NaN;
  @property({ type: Boolean }) near = false;

  override render(): TemplateResult {
    const known = Number.isFinite(this.share);
    const percent = Math.round(this.share * 100);
    const shown = known ? this.near ? msg(str`${this.value}, near its end`) : this.value : msg("not known");
    return html`<span>${this.name}</span>
      <span class="value ${known ? (this.near ? "near" : "") : "old"}">${known ? shown : "–"}</span>
      ${known
        ? html`<div class="way" role="meter" aria-label=${this.name} aria-valuemin="0" aria-valuemax="100" aria-valuenow=${percent} aria-valuetext=${shown}>
            <div class="here" ${styled({ "inset-inline-start": `${String(percent)}%` })}></div>
          </div>`
        : html`<div class="way" role="img" aria-label=${`${this.name}: ${shown}`}></div>`}
      <span class="end">${this.low}</span><span class="end">${this.high}</span>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-joint": JointBar;
  }
}
