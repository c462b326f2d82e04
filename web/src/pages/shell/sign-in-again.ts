/** Over the page of a person whose session ended: they sign in where they are, and go on there. */

import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { consume } from "@lit/context";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { routerContext, sessionContext } from "../../state/contexts.js";
import type { Router } from "../../state/router.js";
import "../../elements/feedback/dialog.js";
import "../../elements/forms/button.js";
import "../sign-in/sign-in-form.js";

@customElement("t-sign-in-again")
export class SignInAgain extends LitElement {
  static override styles = [base];

  @consume({ context: routerContext }) private readonly router!: Router;
  private readonly session = new ContextStoreController(this, sessionContext);

  override render(): TemplateResult {
    const session = this.session.store;
    const open = session?.state === "ended";
    const name = session?.person?.name ?? "";
    return html`<t-dialog heading=${msg("Sign in to go on")} lasting ?open=${open}>
      ${open
        ? html`<t-sign-in-form .who=${name} .returns=${this.router.path} .notice=${session.notice}>
            <p>${msg(str`This page waits, covered, for ${name}. If somebody else signs in, it is forgotten.`)}</p>
          </t-sign-in-form>`
        : nothing}
      ${open ? html`<t-button slot="actions" kind="quiet" @click=${this.leave}>${msg("Leave this page")}</t-button>` : nothing}
    </t-dialog>`;
  }

  private readonly leave = (): void => {
    // Loaded anew: what was held for the person goes with it.
    window.location.assign("/login");
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-sign-in-again": SignInAgain;
  }
}
