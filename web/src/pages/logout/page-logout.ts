/** Log out: asks who came by a link, and says when it is done. */

import { msg, str } from "@lit/localize";
import { html, LitElement, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { doorway } from "../../elements/layout/sign-in-layout.js";
import { sessionContext } from "../../state/contexts.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/loading.js";

@customElement("t-page-logout")
export class PageLogout extends LitElement {
  static override styles = [base, doorway];

  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly action = new ActionController(this);

  override render(): TemplateResult {
    const session = this.session.store;
    if (session?.isSigningOut === true) return html`<t-loading what=${msg("Logging out")}></t-loading>`;
    const person = session?.person ?? null;
    // An address that somebody else wrote must not end a session: it is asked for.
    return person === null
      ? html`<div class="sheet">
          <h1>${msg("You are logged out")}</h1>
          <p class="muted">${msg("Nothing of what you saw is left on this page.")}</p>
          <p><a href="/login">${msg("Sign in again")}</a></p>
        </div>`
      : html`<div class="sheet">
          <h1>${msg("Log out?")}</h1>
          <p>${msg(str`You are signed in as ${person.name}. A device that you hold is let go.`)}</p>
          <t-button kind="primary" @click=${this.endSession}>${msg("Log out")}</t-button>
          <p><a href="/">${msg("Stay signed in")}</a></p>
        </div>`;
  }

  private readonly endSession = (): void => {
    void this.action.run(msg("log you out"), () => this.session.store?.logout() ?? Promise.resolve());
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-logout": PageLogout;
  }
}
