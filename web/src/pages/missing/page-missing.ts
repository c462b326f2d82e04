import { html, LitElement, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { base } from "../../elements/base.js";

@customElement("t-page-missing")
export class PageMissing extends LitElement {
  static override styles = base;

  override render(): TemplateResult {
    return html`<h1>Missing</h1>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-missing": PageMissing;
  }
}
