/** Sign in, and go where one wanted to. */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { doorway } from "../../elements/layout/sign-in-layout.js";
import { routerContext, sessionContext } from "../../state/contexts.js";
import { returnPath, type Router } from "../../state/router.js";
import "../../elements/forms/language-choice.js";
import "./sign-in-form.js";

@customElement("t-page-sign-in")
export class PageSignIn extends LitElement {
  static override styles = [
    base,
    doorway,
    css`
      p {
        margin: 0;
      }
    `,
  ];

  @consume({ context: routerContext }) private readonly router!: Router;
  // Signed in already, here or in another tab, or just now.
  private readonly session = new ContextStoreController(this, sessionContext, (session) => {
    if (session.state === "known") this.router.replace(this.returns);
  });

  override render(): TemplateResult {
    return html`<div class="sheet">
      <t-sign-in-form .returns=${this.returns} .notice=${this.session.store?.notice ?? ""}>
        <h1>Talaia</h1>
        <p class="muted">${msg("The control room for your robots")}</p>
      </t-sign-in-form>
      <t-language-choice></t-language-choice>
    </div>`;
  }

  private get returns(): string {
    return returnPath(this.router.search, this.router.origin);
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-sign-in": PageSignIn;
  }
}
