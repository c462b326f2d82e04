import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../base/base-style.js";
import "../forms/button.js";
import "../base/icon.js";

/**
 * Something went wrong: what happened, and what to do.
 *
 * @fires t-retry when the button is pressed; there is one when `retry` says what it is called
 */
@customElement("t-problem")
export class ProblemPanel extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: auto 1fr;
        align-content: start;
        gap: var(--t-space-2) var(--t-space-3);
        padding: var(--t-space-4);
        border: 1px solid var(--t-line);
        border-inline-start: 4px solid var(--t-bad);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
      }
      t-icon {
        color: var(--t-bad);
      }
      .what {
        font-weight: var(--t-weight-strong);
      }
      .how {
        color: var(--t-muted);
        overflow-wrap: anywhere;
      }
      t-button {
        margin-block-start: var(--t-space-3);
      }
    `,
  ];

  /** What happened. */
  @property() what = "";
  /** What to do about it. */
  @property() how = "";
  /** Words of the button; empty for none. */
  @property() retry = "";

  override connectedCallback(): void {
    super.connectedCallback();
    this.setAttribute("role", "alert");
  }

  override render(): TemplateResult {
    return html`
      <t-icon name="warn"></t-icon>
      <div>
        <p class="what">${this.what}</p>
        ${this.how === "" ? nothing : html`<p class="how">${this.how}</p>`}
        ${this.retry === "" ? nothing : html`<t-button @click=${this.fireRetry}>${this.retry}</t-button>`}
      </div>
    `;
  }

  private readonly fireRetry = (): void => {
    this.dispatchEvent(new CustomEvent("t-retry"));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-problem": ProblemPanel;
  }
}
