/** Real-time page of one site. */

import { html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../../elements/base.js";

@customElement("t-page-live")
export class PageLive extends LitElement {
  static override styles = base;

  @property() site = "";

  override render(): TemplateResult {
    return html`<h1>Real-time</h1>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-live": PageLive;
  }
}
