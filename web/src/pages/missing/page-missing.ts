/** An address that leads nowhere. */

import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import "../../elements/feedback/empty.js";

@customElement("t-page-missing")
export class PageMissing extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        padding-block: var(--t-space-6);
      }
    `,
  ];

  override render(): TemplateResult {
    return html`<t-empty heading=${msg("There is no page here")} icon="unlinked" page>
      <p>${msg(html`The address may be mistyped, or the page has moved. <a href="/home">Go to the home page</a>.`)}</p>
    </t-empty>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-missing": PageMissing;
  }
}
