import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { LEAST_K, MOST_K, USUAL_K } from "../../series/outliers.js";
import { base, quietText } from "../base/base-style.js";
import { control } from "../forms/input-style.js";
import "../forms/button.js";

/**
 * The button "Outliers" and, once pressed, how far out a sample must be.
 *
 * @fires t-outliers detail is `k`, or 0 for none
 */
@customElement("t-outlier-tool")
export class OutlierTool extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        display: inline-flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2);
      }
      label {
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-2);
        ${quietText}
        font-weight: var(--t-weight-strong);
      }
      input {
        inline-size: 5rem;
      }
    `,
  ];

  /** So many times the distance of the quartiles; 0 while none are shown. */
  @property({ type: Number }) k = 0;

  override render(): TemplateResult {
    const on = this.k > 0;
    return html`<t-button pressed=${on ? "true" : "false"} @click=${this.toggle}>${msg("Outliers")}</t-button>
      ${on
          ? html`<label title=${msg("A sample so many times the distance of the quartiles beyond them is an outlier")}
              >${msg("beyond", { id: "beyond.outliers" })} <input type="number" aria-label=${msg("Times the interquartile range")} min=${LEAST_K} max=${MOST_K} step="0.5" .value=${String(this.k)} @change=${this.onInput} /> ${msg("× IQR")}</label
            >`
          : nothing}`;
  }

  private readonly toggle = (): void => {
    this.fireChange(this.k > 0 ? 0 : USUAL_K);
  };

  private readonly onInput = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    const k = event.target.valueAsNumber;
    const kept = Number.isFinite(k) ? Math.min(MOST_K, Math.max(LEAST_K, k)) : this.k;
    event.target.value = String(kept);
    this.fireChange(kept);
  };

  private fireChange(detail: number): void {
    this.dispatchEvent(new CustomEvent("t-outliers", { detail }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-outlier-tool": OutlierTool;
  }
  interface HTMLElementEventMap {
    "t-outliers": CustomEvent<number>;
  }
}
