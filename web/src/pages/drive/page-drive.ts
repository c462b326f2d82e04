/** Actuate page of one site. */

import { html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../../elements/base.js";

@customElement("t-page-drive")
export class PageDrive extends LitElement {
  static override styles = base;

  @property() site = "";

  override render(): TemplateResult {
    return html`<h1>Actuate</h1>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-drive": PageDrive;
  }
}
