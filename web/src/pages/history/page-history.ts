/** History page of one site. */

import { html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../../elements/base.js";

@customElement("t-page-history")
export class PageHistory extends LitElement {
  static override styles = base;

  @property() site = "";

  override render(): TemplateResult {
    return html`<h1>History</h1>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-history": PageHistory;
  }
}
