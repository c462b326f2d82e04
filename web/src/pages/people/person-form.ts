/** Who is to be added. */

import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import { focusInside } from "../../elements/base/focus.js";
import { renderFormActions, renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { NewPassword } from "../../elements/forms/new-password.js";
import { sheets } from "../../elements/layout/page-sections.js";
import type { Advice } from "../../format/error-advice.js";
import type { PersonAsk, RoleShape } from "../../generated/api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/field.js";

/**
 * @fires t-add detail is who is to be added
 * @fires t-cancel
 */
@customElement("t-person-form")
export class PersonForm extends LitElement {
  static override styles = [
    base,
    sheets,
    forms,
    css`
      form {
        padding-block: var(--t-space-3);
      }
    `,
  ];

  @property({ attribute: false }) roles: readonly RoleShape[] = [];
  @property({ attribute: false }) problem: Advice | null = null;
  @property({ type: Boolean }) busy = false;
  @state() private name = "";
  @state() private missing = "";
  @query("#role") private readonly roleBox!: HTMLSelectElement;
  private readonly password = new NewPassword(this, () => this.name);

  override firstUpdated(): void {
    void focusInside(this, "input");
  }

  override render(): TemplateResult {
    return html`<form class="entry" novalidate @submit=${this.onSubmit}>
        <h2>${msg("Add a person")}</h2>
        <t-field label=${msg("Name")} error=${this.missing}>
          <input id="name" autocomplete="off" autocapitalize="none" spellcheck="false" maxlength="100" @input=${this.onNameInput} />
        </t-field>
        <t-field label=${msg("Role")} hint=${msg("Its permissions are listed on the Roles page.")}>
          <select id="role">
            ${renderOptions(this.roles.map(({ name }) => name), "operator")}
          </select>
        </t-field>
        ${this.password.render(msg("First password"), msg("Give it to the person; they can change it."))} ${renderAdvice(this.problem)}
        ${renderFormActions({ submit: msg("Add this person"), busy: this.busy, cancel: this.onCancel })}
      </form>`;
  }

  private readonly onNameInput = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.name = event.target.value;
    this.missing = "";
  };

  private readonly onCancel = (): void => {
    this.dispatchEvent(new CustomEvent("t-cancel"));
  };

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    if (this.busy) return;
    const name = this.name.trim();
    this.missing = name === "" ? msg("Enter a name.") : "";
    if (!this.password.validate() || name === "") return;
    const detail: PersonAsk = { name, password: this.password.value, role: this.roleBox.value };
    this.dispatchEvent(new CustomEvent("t-add", { detail }));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-person-form": PersonForm;
  }
  interface GlobalEventHandlersEventMap {
    "t-add": CustomEvent<PersonAsk>;
  }
}
