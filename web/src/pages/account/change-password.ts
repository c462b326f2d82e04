/** Change one's own password. */

import { consume } from "@lit/context";
import { html, LitElement, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { base } from "../../elements/base/base-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { passwordRules, passwordProblem } from "../../format/password-rules.js";
import { apiContext } from "../../state/contexts.js";
import { AccountApi } from "../../wire/account-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../../elements/forms/rule-list.js";

@customElement("t-account-password")
export class ChangePassword extends LitElement {
  static override styles = [base, sheets];

  @property() name = "";
  @state() private fresh = "";
  @state() private again = "";
  @state() private missing = "";
  @state() private trouble = "";
  @query("form") private readonly form!: HTMLFormElement;
  @query("#old") private readonly old!: HTMLInputElement;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);

  override render(): TemplateResult {
    const { problem, doneText: done, busy } = this.action;
    return html`<h2>Password</h2>
      <form class="fields" novalidate @submit=${this.onSubmit}>
        <input hidden name="username" autocomplete="username" .value=${this.name} />
        <t-field label="Password now" error=${this.missing}>
          <input id="old" type="password" autocomplete="current-password" required />
        </t-field>
        <t-field label="New password" error=${this.trouble}>
          <input id="fresh" type="password" autocomplete="new-password" required @input=${this.onInput} />
        </t-field>
        <t-field label="New password, once more">
          <input id="again" type="password" autocomplete="new-password" required @input=${this.onInput} />
        </t-field>
        <t-rules .rules=${this.rules()}></t-rules>
        ${renderAdvice(problem)}
        <div class="actions">
          <t-button type="submit" kind="primary" ?busy=${busy}>Change the password</t-button>
          <span class="said" role="status">${done}</span>
        </div>
        <p class="muted">Every other session of yours ends with it.</p>
      </form>`;
  }

  private rules(): ReturnType<typeof passwordRules> {
    return passwordRules(this.fresh, this.name, this.again);
  }

  private readonly onInput = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    if (event.target.id === "fresh") this.fresh = event.target.value;
    else this.again = event.target.value;
    this.trouble = "";
    this.action.clear();
  };

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    this.missing = this.old.value === "" ? "Enter the password you have now." : "";
    this.trouble = passwordProblem(this.rules());
    if (this.missing === "" && this.trouble === "") void this.changePassword(this.old.value, this.fresh);
  };

  private async changePassword(old: string, fresh: string): Promise<void> {
    const api = new AccountApi(this.api);
    if (!(await this.action.run("change the password", () => api.changePassword(old, fresh), "It is changed."))) return;
    this.form.reset();
    this.fresh = this.again = "";
    this.dispatchEvent(new CustomEvent("t-changed", { bubbles: true, composed: true }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-account-password": ChangePassword;
  }
}
