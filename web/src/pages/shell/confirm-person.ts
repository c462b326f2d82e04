/** Asks the person for their password, and their second factor, before rights are given away. */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, query, state } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { focusInside } from "../../elements/base/focus.js";
import { forms } from "../../elements/forms/form-style.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { apiContext, sessionContext } from "../../state/contexts.js";
import { AccountApi } from "../../wire/account-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { hasPasskeys } from "../../wire/passkeys.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/dialog.js";
import "../../elements/forms/field.js";

/** The question; `askPerson` opens it, and whatever closes it answers. */
@customElement("t-confirm-person")
export class ConfirmPerson extends LitElement {
  static override styles = [
    base,
    forms,
    css`
      form {
        display: grid;
        gap: var(--t-space-4);
      }
      p {
        margin: 0;
      }
    `,
  ];

  @state() private open = false;
  @state() private missing: "" | "password" | "code" = "";
  @query("#password") private readonly password!: HTMLInputElement;
  @query("#code") private readonly code!: HTMLInputElement | null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly action = new ActionController(this);
  private asked: Promise<boolean> | null = null;
  private answer: (confirmed: boolean) => void = () => undefined;

  /** Asks; whoever asks meanwhile gets the same answer. */
  readonly askPerson = (): Promise<boolean> => {
    this.asked ??= new Promise((resolve) => {
      this.answer = resolve;
      this.missing = "";
      this.action.clear();
      this.open = true;
      void this.updateComplete.then(() => focusInside(this, "#password"));
    });
    return this.asked;
  };

  override render(): TemplateResult {
    const { busy } = this.action;
    // Only while it asks: a page has no field for a password that nobody is asked for.
    return html`<t-dialog heading=${msg("Confirm that it is you")} ?open=${this.open} @t-close=${this.onClosed}>
      ${this.open ? this.renderForm() : nothing}
      <t-button slot="actions" @click=${this.closeQuestion}>${msg("Cancel")}</t-button>
      ${this.session.store?.person?.password === false
        ? html`<t-button slot="actions" kind="primary" ?busy=${busy} @click=${this.confirmByProvider}>${msg("Sign in anew")}</t-button>`
        : html`<t-button slot="actions" kind="primary" ?busy=${busy} @click=${this.confirm}>${msg("Confirm")}</t-button>`}
    </t-dialog>`;
  }

  private renderForm(): TemplateResult {
    const person = this.session.store?.person;
    if (person?.password === false) {
      return html`<p>
          ${msg("What you are about to do gives rights to somebody, or takes a protection away. Sign in anew where you have your password; you come back to this page. Then do it once more.")}
        </p>
        ${renderAdvice(this.action.problem)}`;
    }
    return html`<form novalidate @submit=${this.onSubmit}>
      <p>${msg("What you are about to do gives rights to somebody, or takes a protection away. You are asked again after five minutes.")}</p>
      <input hidden name="username" autocomplete="username" .value=${person?.name ?? ""} />
      <t-field label=${msg("Your password")} error=${this.missing === "password" ? msg("Enter your password.") : ""}>
        <input id="password" type="password" autocomplete="current-password" required />
      </t-field>
      ${person?.factor === true
        ? html`<t-field
            label=${msg("Code")}
            hint=${msg("Six digits from your app, or one of your recovery codes")}
            error=${this.missing === "code" ? msg("Enter the code.") : ""}
          >
            <input id="code" autocomplete="one-time-code" autocapitalize="none" spellcheck="false" required />
          </t-field>`
        : nothing}
      ${person?.factor === true && hasPasskeys()
        ? html`<div><t-button ?busy=${this.action.runningKey === "passkey"} @click=${this.confirmByPasskey}>${msg("Use a passkey")}</t-button></div>`
        : nothing}
      ${renderAdvice(this.action.problem)}
      <button type="submit" hidden></button>
    </form>`;
  }

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    void this.confirm();
  };

  private readonly confirm = async (): Promise<void> => {
    const password = this.password.value;
    const code = this.code?.value.replace(/\s+/g, "") ?? "";
    if (password === "") this.missing = "password";
    else if (this.code !== null && code === "") this.missing = "code";
    else this.missing = "";
    if (this.missing !== "") {
      void focusInside(this, `#${this.missing}`);
      return;
    }
    const done = await this.action.run(msg("take this"), () => new AccountApi(this.api).confirm(password, code));
    if (done) this.finish(true);
    else void focusInside(this, this.code === null ? "#password" : "#code");
  };

  private readonly confirmByProvider = (): void => {
    void this.action.run(msg("send you there"), async () => {
      window.location.assign(await this.api.beginOidc("/api/me/oidc/confirm", window.location.pathname));
    });
  };

  private readonly confirmByPasskey = (): void => {
    const api = new AccountApi(this.api);
    void this.action.run(msg("take this"), () => api.confirmByPasskey(this.password.value), "", "passkey").then((done) => {
      if (done) this.finish(true);
    });
  };

  private readonly closeQuestion = (): void => {
    this.finish(false);
  };

  private readonly onClosed = (): void => {
    this.finish(false);
  };

  private finish(confirmed: boolean): void {
    this.open = false;
    this.asked = null;
    this.answer(confirmed);
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-confirm-person": ConfirmPerson;
  }
}
