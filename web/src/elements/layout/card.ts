import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { base, raisedBox } from "../base/base-style.js";

/**
 * A sheet that holds what belongs together.
 *
 * @slot - anything
 */
@customElement("t-card")
export class Card extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        padding: var(--t-space-4);
        ${raisedBox}
      }
    `,
  ];

  override render(): TemplateResult {
    return html`<slot></slot>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-card": Card;
  }
}
