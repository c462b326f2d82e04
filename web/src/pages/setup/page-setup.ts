/** First start: the holder of the one-time link makes the first admin. */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { html, LitElement, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import { NewPassword } from "../../elements/forms/new-password.js";
import { doorway } from "../../elements/layout/sign-in-layout.js";
import { adviceFor, type Advice } from "../../format/error-advice.js";
import { apiContext, routerContext, sessionContext } from "../../state/contexts.js";
import type { Router } from "../../state/router.js";
import type { Session } from "../../state/session.js";
import { Refused, type HubApi } from "../../wire/hub-api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../../elements/feedback/problem.js";

@customElement("t-page-setup")
export class PageSetup extends LitElement {
  static override styles = [base, doorway];

  @state() private busy = false;
  @state() private done = false;
  @state() private advice: Advice | null = null;
  @state() private missing = "";
  @state() private name = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  @consume({ context: sessionContext }) private readonly session!: Session;
  @consume({ context: routerContext }) private readonly router!: Router;
  private readonly password = new NewPassword(this, () => this.name);

  override render(): TemplateResult {
    if (this.done) return this.renderFinished();
    if (this.token() === "") return this.renderNoToken();
    return html`
      <form novalidate @submit=${this.onSubmit}>
        <div>
          <h1>${msg("Set up Talaia")}</h1>
          <p class="muted">${msg("Choose who the first admin is. This link works once.")}</p>
        </div>
        ${renderAdvice(this.advice)}
        <t-field label=${msg("Name")} error=${this.missing}>
          <input id="name" autocomplete="username" autocapitalize="none" spellcheck="false" required @input=${this.onInput} />
        </t-field>
        ${this.password.render(msg("Password"))}
        <t-button type="submit" kind="primary" ?busy=${this.busy}>${msg("Make this admin")}</t-button>
      </form>
    `;
  }

  private renderFinished(): TemplateResult {
    return html`<div class="sheet">
      <h1>${msg("Done")}</h1>
      <p>${msg("The first admin is made. Sign in with the name and password you chose.")}</p>
      <t-button kind="primary" @click=${this.openSignIn}>${msg("Go to sign-in")}</t-button>
    </div>`;
  }

  private renderNoToken(): TemplateResult {
    return html`<div class="sheet">
      <h1>${msg("Set up Talaia")}</h1>
      <t-problem
        what=${msg("This address has no set-up code.")}
        how=${msg("Open the whole link that the hub printed when it was started for the first time.")}
      ></t-problem>
    </div>`;
  }

  private token(): string {
    return this.router.hash.replace(/^#/, "");
  }

  private readonly openSignIn = (): void => {
    this.router.replace("/login");
  };

  private readonly onInput = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.name = event.target.value;
    this.missing = "";
  };

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    if (this.busy) return;
    const name = this.name.trim();
    this.missing = name === "" ? msg("Enter a name.") : "";
    if (this.password.validate() && name !== "") void this.createAdmin(name, this.password.value);
  };

  private async createAdmin(name: string, password: string): Promise<void> {
    this.busy = true;
    this.advice = null;
    try {
      await this.api.setUpAdmin(this.token(), name, password);
      await this.session.refresh();
      // The hub signs in whom it has just made; if it did not, the person does so by hand.
      if (this.session.state === "known") this.router.replace("/home");
      else this.done = true;
    } catch (error) {
      this.advice =
        error instanceof Refused
          ? { what: msg("The hub did not make this admin."), how: error.message }
          : adviceFor(error, msg("the set-up"));
    } finally {
      this.busy = false;
    }
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-setup": PageSetup;
  }
}
