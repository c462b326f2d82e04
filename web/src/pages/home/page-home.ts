import { html, LitElement, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { base } from "../../elements/base.js";

@customElement("t-page-home")
export class PageHome extends LitElement {
  static override styles = base;

  override render(): TemplateResult {
    return html`<h1>Home</h1>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-home": PageHome;
  }
}
