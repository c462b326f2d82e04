import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { renderIconPath, type IconName } from "./icons.js";

/** One of our icons, as large as the text around it asks. Hidden from screen readers. */
@customElement("t-icon")
export class Icon extends LitElement {
  static override styles = css`
    :host {
      display: inline-flex;
      inline-size: 1.4em;
      block-size: 1.4em;
      flex: none;
    }
    svg {
      inline-size: 100%;
      block-size: 100%;
    }
  `;

  @property() name: IconName = "info";

  override render(): TemplateResult {
    return html`<svg viewBox="0 0 24 24" aria-hidden="true">${renderIconPath(this.name)}</svg>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-icon": Icon;
  }
}
