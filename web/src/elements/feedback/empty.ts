import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../base/base-style.js";
import type { IconName } from "../base/icons.js";
import "../base/icon.js";

/**
 * Nothing is here, and what to do about it.
 *
 * @slot - one or two sentences, and a button if there is something to press
 */
@customElement("t-empty")
export class Empty extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        /* Together in the middle, however much room there is. */
        align-content: center;
        justify-items: center;
        gap: var(--t-space-2);
        padding: var(--t-space-6) var(--t-space-4);
        border: 1px dashed var(--t-line);
        border-radius: var(--t-radius);
        color: var(--t-muted);
        text-align: center;
      }
      t-icon {
        font-size: var(--t-size-xl);
      }
      :is(h1, h2) {
        color: var(--t-text);
        font-size: var(--t-size-l);
      }
      .more {
        max-inline-size: 34rem;
      }
    `,
  ];

  @property() heading = "";
  @property() icon: IconName | "" = "";
  /** It is all that the page has: its heading is the page's. */
  @property({ type: Boolean }) page = false;

  override render(): TemplateResult {
    return html`
      ${this.icon === "" ? nothing : html`<t-icon name=${this.icon}></t-icon>`}
      ${this.page ? html`<h1>${this.heading}</h1>` : html`<h2>${this.heading}</h2>`}
      <div class="more"><slot></slot></div>
    `;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-empty": Empty;
  }
}
