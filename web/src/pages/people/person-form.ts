/** Who is to be added. */

import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base } from "../../elements/base/base-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { passwordRules, passwordProblem } from "../../format/password-rules.js";
import type { Advice } from "../../format/error-advice.js";
import type { RoleRow } from "../../wire/admin-types.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../../elements/forms/rule-list.js";

export interface NewPerson {
  readonly name: string;
  readonly password: string;
  readonly role: string;
}

/**
 * @fires t-add detail is who is to be added
 * @fires t-cancel
 */
@customElement("t-person-form")
export class PersonForm extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      form {
        display: grid;
        gap: var(--t-space-4);
        padding-block: var(--t-space-3);
      }
      .fields {
        grid-template-columns: repeat(auto-fit, minmax(min(16rem, 100%), 1fr));
        max-inline-size: none;
        align-items: start;
      }
    `,
  ];

  @property({ attribute: false }) roles: readonly RoleRow[] = [];
  @property({ attribute: false }) problem: Advice | null = null;
  @property({ type: Boolean }) busy = false;
  @state() private typed = { name: "", password: "", again: "" };
  @state() private errors = { name: "", password: "" };
  @query("#name") private readonly name!: HTMLInputElement;
  @query("#role") private readonly roleBox!: HTMLSelectElement;

  override firstUpdated(): void {
    void this.name.closest("t-field")?.updateComplete.then(() => {
      this.name.focus();
    });
  }

  override render(): TemplateResult {
    return html`<form novalidate @submit=${this.onSubmit}>
      <h2>Add a person</h2>
      <div class="fields">
        <t-field label="Name" error=${this.errors.name}>
          <input id="name" autocomplete="off" autocapitalize="none" spellcheck="false" maxlength="100" @input=${this.onInput} />
        </t-field>
        <t-field label="Role" hint="Its permissions are listed on the Roles page.">
          <select id="role">
            ${map(
              this.roles,
              ({ name }) => html`<option value=${name} .selected=${name === "operator"}>${name}</option>`,
            )}
          </select>
        </t-field>
        <t-field label="First password" hint="Give it to the person; they can change it." error=${this.errors.password}>
          <input id="password" type="password" autocomplete="new-password" @input=${this.onInput} />
        </t-field>
        <t-field label="First password, once more">
          <input id="again" type="password" autocomplete="new-password" @input=${this.onInput} />
        </t-field>
      </div>
      <t-rules .rules=${this.rules()}></t-rules>
      ${renderAdvice(this.problem)}
      <div class="actions">
        <t-button type="submit" kind="primary" ?busy=${this.busy}>Add this person</t-button>
        <t-button @click=${this.onCancel}>Cancel</t-button>
      </div>
    </form>`;
  }

  private rules(): ReturnType<typeof passwordRules> {
    return passwordRules(this.typed.password, this.typed.name, this.typed.again);
  }

  private readonly onInput = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    this.typed = { ...this.typed, [event.target.id]: event.target.value };
    this.errors = { name: "", password: "" };
  };

  private readonly onCancel = (): void => {
    this.dispatchEvent(new CustomEvent("t-cancel"));
  };

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    if (this.busy) return;
    const name = this.typed.name.trim();
    this.errors = { name: name === "" ? "Enter a name." : "", password: passwordProblem(this.rules()) };
    if (this.errors.name !== "" || this.errors.password !== "") return;
    const detail: NewPerson = { name, password: this.typed.password, role: this.roleBox.value };
    this.dispatchEvent(new CustomEvent("t-add", { detail }));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-person-form": PersonForm;
  }
  interface GlobalEventHandlersEventMap {
    "t-add": CustomEvent<NewPerson>;
  }
}
