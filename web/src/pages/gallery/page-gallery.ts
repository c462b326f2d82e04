import { html, LitElement, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { base } from "../../elements/base.js";

@customElement("t-page-gallery")
export class PageGallery extends LitElement {
  static override styles = base;

  override render(): TemplateResult {
    return html`<h1>Gallery</h1>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-gallery": PageGallery;
  }
}
