/** Which roles require a second factor. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { base } from "../../elements/base/base-style.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { forms } from "../../elements/forms/form-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import type { RoleShape } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";

/** @fires t-changed a role requires one now, or does not any more */
@customElement("t-role-factors")
export class RoleFactors extends LitElement {
  static override styles = [
    base,
    sheets,
    forms,
    css`
      .ticks {
        display: flex;
        flex-wrap: wrap;
        gap: 0 var(--t-space-5);
      }
      p {
        max-inline-size: 60rem;
      }
    `,
  ];

  @property({ attribute: false }) roles: readonly RoleShape[] = [];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);

  override render(): TemplateResult {
    return html`<h2>${msg("Second factor required")}</h2>
      <p>${msg("Who has such a role and no second factor sets one up at the next sign-in, before anything else; people who are signed in, at once.")}</p>
      <div class="ticks">${map(this.roles, (role) => this.renderTick(role))}</div>
      ${renderAdvice(this.action.problem)}
      <p class="visually-hidden" role="status">${this.action.doneText}</p>`;
  }

  private renderTick(role: RoleShape): TemplateResult {
    return html`<label class="tick"
      ><input type="checkbox" .checked=${role.factor_required} ?disabled=${this.action.busy} @change=${this.changer(role)} />${role.name}</label
    >`;
  }

  private changer(role: RoleShape): (event: Event) => void {
    return (event) => {
      const box = event.target;
      if (!(box instanceof HTMLInputElement)) return;
      const required = box.checked;
      const done = required ? msg(str`${role.name}: a second factor is required.`) : msg(str`${role.name}: a second factor is not required any more.`);
      void this.action.run(msg("change this"), () => new AdminApi(this.api).requireFactor(role.id, required), done).then((changed) => {
        // What the hub refused is not so.
        if (changed) this.dispatchEvent(new CustomEvent("t-changed"));
        else box.checked = role.factor_required;
      });
    };
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-role-factors": RoleFactors;
  }
}
