/** One's account at the provider of sign-ins, where the hub has one. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { apiContext } from "../../state/contexts.js";
import { AccountApi } from "../../wire/account-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import "../../elements/forms/button.js";

@customElement("t-account-provider")
export class AccountProvider extends LitElement {
  static override styles = [base, sheets];

  /** There is no password here: one signs in by the provider alone. */
  @property({ type: Boolean }) only = false;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly provider = new LoadController<string>(this);
  private readonly connection = new LoadController<boolean>(this);
  private readonly action = new ActionController(this);

  override willUpdate(): void {
    this.provider.load("provider", () => this.api.provider());
    this.connection.load("connection", () => new AccountApi(this.api).isConnected());
  }

  override updated(): void {
    this.hidden = (this.provider.value ?? "") === "";
  }

  override render(): TemplateResult | typeof nothing {
    const label = this.provider.value ?? "";
    if (label === "") return nothing;
    if (this.only) {
      return html`<h2>${msg(str`Sign-in with ${label}`)}</h2>
        <p>${msg(str`You sign in with ${label} and have no password here. An admin can give you one.`)}</p>`;
    }
    if (this.connection.value === true) {
      return html`<h2>${msg(str`Sign-in with ${label}`)}</h2>
        <p>${msg(str`${label} signs you in, beside your password.`)}</p>
        ${renderAdvice(this.action.problem)}
        <div class="actions"><t-button ?busy=${this.action.busy} @click=${this.onDisconnect}>${msg("Disconnect it")}</t-button></div>`;
    }
    return html`<h2>${msg(str`Sign-in with ${label}`)}</h2>
      <p>${msg(str`Connect this account, and ${label} signs you in, too.`)}</p>
      ${renderAdvice(this.action.problem)}
      <div class="actions"><t-button ?busy=${this.action.busy} @click=${this.onConnect}>${msg("Connect it")}</t-button></div>`;
  }

  private readonly onDisconnect = (): void => {
    void this.action
      .run(msg("disconnect it"), () => new AccountApi(this.api).disconnect(), msg("Disconnected."))
      .finally(this.connection.invalidate);
  };

  private readonly onConnect = (): void => {
    void this.action.run(msg("connect it"), async () => {
      window.location.assign(await this.api.beginOidc("/api/me/oidc/connect", "/account"));
    });
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-account-provider": AccountProvider;
  }
}
