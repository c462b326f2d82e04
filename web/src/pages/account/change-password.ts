/** Change one's own password. */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { html, LitElement, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { base } from "../../elements/base/base-style.js";
import { renderFormActions } from "../../elements/forms/form-parts.js";
import { NewPassword } from "../../elements/forms/new-password.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { apiContext } from "../../state/contexts.js";
import { AccountApi } from "../../wire/account-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/field.js";

@customElement("t-account-password")
export class ChangePassword extends LitElement {
  static override styles = [base, sheets];

  @property() name = "";
  @state() private missing = "";
  @query("form") private readonly form!: HTMLFormElement;
  @query("#old") private readonly old!: HTMLInputElement;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);
  private readonly password = new NewPassword(this, () => this.name);

  override render(): TemplateResult {
    const { problem, doneText: done, busy } = this.action;
    return html`<h2>${msg("Password")}</h2>
      <form class="fields" novalidate @submit=${this.onSubmit} @input=${this.action.clear}>
        <input hidden name="username" autocomplete="username" .value=${this.name} />
        <t-field label=${msg("Password now")} error=${this.missing}>
          <input id="old" type="password" autocomplete="current-password" required />
        </t-field>
        ${this.password.render(msg("New password"))} ${renderAdvice(problem)}
        ${renderFormActions({ submit: msg("Change the password"), busy }, html`<span class="said" role="status">${done}</span>`)}
        <p class="muted">${msg("Every other session of yours ends with it, and every token for scripts.")}</p>
      </form>`;
  }

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    this.missing = this.old.value === "" ? msg("Enter the password you have now.") : "";
    if (this.password.validate() && this.missing === "") void this.changePassword(this.old.value, this.password.value);
  };

  private async changePassword(old: string, fresh: string): Promise<void> {
    const api = new AccountApi(this.api);
    if (!(await this.action.run(msg("change the password"), () => api.changePassword(old, fresh), msg("It is changed.")))) return;
    this.form.reset();
    this.password.clear();
    this.dispatchEvent(new CustomEvent("t-changed", { bubbles: true, composed: true }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-account-password": ChangePassword;
  }
}
