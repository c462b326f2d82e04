/** First start: the holder of the one-time link makes the first admin. */

import { consume } from "@lit/context";
import { html, LitElement, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import { doorway } from "../../elements/layout/sign-in-layout.js";
import { passwordRules, passwordProblem } from "../../format/password-rules.js";
import { adviceFor, type Advice } from "../../format/error-advice.js";
import { apiContext, routerContext, sessionContext } from "../../state/contexts.js";
import type { Router } from "../../state/router.js";
import type { Session } from "../../state/session.js";
import { Refused, type HubApi } from "../../wire/hub-api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../../elements/feedback/problem.js";
import "../../elements/forms/rule-list.js";

const NO_ERRORS = { name: "", password: "" } as const;

@customElement("t-page-setup")
export class PageSetup extends LitElement {
  static override styles = [base, doorway];

  @state() private busy = false;
  @state() private done = false;
  @state() private advice: Advice | null = null;
  @state() private errors: Readonly<Record<"name" | "password", string>> = NO_ERRORS;
  @state() private name = "";
  @state() private password = "";
  @state() private again = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  @consume({ context: sessionContext }) private readonly session!: Session;
  @consume({ context: routerContext }) private readonly router!: Router;

  override render(): TemplateResult {
    if (this.done) return this.renderFinished();
    if (this.token() === "") return this.renderNoToken();
    return html`
      <form novalidate @submit=${this.onSubmit}>
        <div>
          <h1>Set up Talaia</h1>
          <p class="muted">Choose who the first admin is. This link works once.</p>
        </div>
        ${renderAdvice(this.advice)}
        <t-field label="Name" error=${this.errors.name}>
          <input id="name" autocomplete="username" autocapitalize="none" spellcheck="false" required @input=${this.onInput} />
        </t-field>
        <t-field label="Password" error=${this.errors.password}>
          <input id="password" type="password" autocomplete="new-password" required @input=${this.onInput} />
        </t-field>
        <t-field label="Password, once more">
          <input id="again" type="password" autocomplete="new-password" required @input=${this.onInput} />
        </t-field>
        <t-rules .rules=${this.rules()}></t-rules>
        <t-button type="submit" kind="primary" ?busy=${this.busy}>Make this admin</t-button>
      </form>
    `;
  }

  private renderFinished(): TemplateResult {
    return html`<div class="sheet">
      <h1>Done</h1>
      <p>The first admin is made. Sign in with the name and password you chose.</p>
      <t-button kind="primary" @click=${this.openSignIn}>Go to sign-in</t-button>
    </div>`;
  }

  private renderNoToken(): TemplateResult {
    return html`<div class="sheet">
      <h1>Set up Talaia</h1>
      <t-problem
        what="This address has no set-up code."
        how="Open the whole link that the hub printed when it was started for the first time."
      ></t-problem>
    </div>`;
  }

  private token(): string {
    return this.router.hash.replace(/^#/, "");
  }

  private readonly openSignIn = (): void => {
    this.router.replace("/login");
  };

  private rules(): ReturnType<typeof passwordRules> {
    return passwordRules(this.password, this.name, this.again);
  }

  private readonly onInput = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    const { id, value } = event.target;
    if (id === "name") this.name = value;
    else if (id === "password") this.password = value;
    else this.again = value;
    this.errors = NO_ERRORS;
  };

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    if (this.busy) return;
    const name = this.name.trim();
    this.errors = { name: name === "" ? "Enter a name." : "", password: passwordProblem(this.rules()) };
    if (Object.values(this.errors).every((error) => error === "")) void this.createAdmin(name, this.password);
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
          ? { what: "The hub did not make this admin.", how: error.message }
          : adviceFor(error, "the set-up");
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
