/** Make a role, or rename or remove one. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { base } from "../../elements/base/base-style.js";
import { focusInside } from "../../elements/base/focus.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { apiContext } from "../../state/contexts.js";
import type { RoleShape } from "../../generated/api.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/dialog.js";
import "../../elements/forms/field.js";

/**
 * @fires t-changed a role was made, renamed or removed
 * @fires t-close
 */
@customElement("t-role-dialog")
export class RoleDialog extends LitElement {
  static override styles = [base, forms];

  @property({ type: Boolean }) open = false;
  /** The role to change; null for a new one. */
  @property({ attribute: false }) edited: RoleShape | null = null;
  @property({ attribute: false }) roles: readonly RoleShape[] = [];
  @state() private missing = "";
  @query("#name") private readonly name!: HTMLInputElement;
  @query("#like") private readonly like!: HTMLSelectElement | null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);

  override updated(changed: PropertyValues<this>): void {
    if (!changed.has("open") || !this.open) return;
    this.name.value = this.edited?.name ?? "";
    this.missing = "";
    this.action.clear();
    void focusInside(this, "input");
  }

  override render(): TemplateResult {
    const role = this.edited;
    const { problem } = this.action;
    const used = (role?.people ?? 0) > 0;
    return html`<t-dialog
      heading=${role === null ? msg("Make a role") : msg(str`Change ${role.name}`)}
      ?open=${this.open}
      @t-close=${this.onClosed}
    >
      <form novalidate @submit=${this.onSubmit}>
        <t-field label=${msg("Name")} error=${this.missing}><input id="name" autocomplete="off" maxlength="100" /></t-field>
        ${role === null
          ? html`<t-field label=${msg("Begin with the rights of")}>
              <select id="like">
                ${renderOptions([["", msg("no other role")], ...this.roles.map(({ id, name }) => [id, name] as const)], "")}
              </select>
            </t-field>`
          : html`<p class="muted">
              ${used
                ? msg(str`${String(role.people)} of the people have this role; give them another before you remove it.`)
                : msg("Nobody has this role.")}
            </p>`}
        ${renderAdvice(problem)}
      </form>
      <t-button slot="actions" @click=${this.closeQuestion}>${msg("Cancel")}</t-button>
      ${role === null
        ? nothing
        : html`<t-button slot="actions" kind="danger" ?disabled=${used} ?busy=${this.action.runningKey === "remove"} @click=${this.removeRole}
            >${msg("Remove")}</t-button
          >`}
      <t-button slot="actions" kind="primary" ?busy=${this.action.runningKey === "save"} @click=${this.saveRole}
        >${role === null ? msg("Make the role") : msg("Rename")}</t-button
      >
    </t-dialog>`;
  }

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    this.saveRole();
  };

  private readonly saveRole = (): void => {
    const name = this.name.value.trim();
    this.missing = name === "" ? msg("Enter a name.") : "";
    if (name === "") return;
    const api = new AdminApi(this.api);
    const role = this.edited;
    const like = this.roles.find(({ id }) => id === this.like?.value)?.permissions ?? [];
    void this.runAction(
      role === null ? msg("make the role") : msg("rename the role"),
      () => (role === null ? api.addRole(name, like) : api.changeRole(role.id, name, role.permissions)),
      "save",
    );
  };

  private readonly removeRole = (): void => {
    const id = this.edited?.id ?? "";
    void this.runAction(msg("remove the role"), () => new AdminApi(this.api).removeRole(id), "remove");
  };

  private async runAction(asked: string, action: () => Promise<void>, key: string): Promise<void> {
    if (await this.action.run(asked, action, "", key)) this.dispatchEvent(new CustomEvent("t-changed"));
  }

  private readonly closeQuestion = (): void => {
    this.open = false;
  };

  private readonly onClosed = (): void => {
    this.dispatchEvent(new CustomEvent("t-close"));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-role-dialog": RoleDialog;
  }
}
