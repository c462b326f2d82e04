/** Who is in a proposal; admins of its site add and remove them. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { base } from "../../elements/base/base-style.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { formText, submittedForm } from "../../format/form-values.js";
import { plural } from "../../words/plural.js";
import type { ProposalRole, ProposalShape } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import type { HubApi } from "../../wire/hub-api.js";
import { ObservingApi } from "../../wire/observing-api.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

const ROLES: Readonly<Record<ProposalRole, string>> = { principal_investigator: msg("principal investigator"), member: msg("member") };

/** @fires t-changed its members are others */
@customElement("t-proposal-members")
export class ProposalMembers extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      form {
        display: flex;
        flex-wrap: wrap;
        align-items: start;
        gap: var(--t-space-2);
      }
      /* Level with the control, below the height of its label. */
      form t-button {
        margin-block-start: calc(var(--t-size-s) * 1.45 + var(--t-space-1));
      }
      ul {
        margin: 0;
        padding: 0;
        list-style: none;
      }
      li {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: 0 var(--t-space-3);
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) proposal: ProposalShape | null = null;
  @property({ type: Boolean }) manages = false;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);

  override render(): TemplateResult | typeof nothing {
    const { proposal } = this;
    if (proposal === null) return nothing;
    const { members } = proposal;
    if (members.length === 0 && !this.manages) return nothing;
    return html`<details ?open=${members.length === 0}>
      <summary>${plural(members.length, msg("1 member"), msg(str`${String(members.length)} members`))}</summary>
      <ul aria-label=${msg(str`Members of ${proposal.id}`)}>
        ${repeat(
          members,
          ({ name }) => name,
          ({ name, role }) => html`<li>
            <span class="name">${name}</span><span class="muted">${ROLES[role]}</span>
            ${this.manages ? html`<t-button kind="quiet" label=${msg(str`Remove ${name} from ${proposal.id}`)} @click=${this.remover(name)}>${msg("Remove")}</t-button>` : nothing}
          </li>`,
        )}
      </ul>
      ${this.manages
        ? html`<form novalidate @submit=${this.onAdd}>
            <t-field label=${msg("Account")}><input name="name" maxlength="200" autocomplete="off" autocapitalize="none" spellcheck="false" /></t-field>
            <t-field label=${msg("Role")}><select name="role">${renderOptions(Object.entries(ROLES), "member")}</select></t-field>
            <t-button type="submit" ?busy=${this.action.busy}>${msg("Add")}</t-button>
          </form>`
        : nothing}
      ${renderAdvice(this.action.problem)}
    </details>`;
  }

  private readonly onAdd = (event: SubmitEvent): void => {
    const said = submittedForm(event);
    const name = said === undefined ? "" : formText(said, "name");
    if (said === undefined || name === "") return;
    this.setMember(name, formText(said, "role") === "principal_investigator" ? "principal_investigator" : "member");
  };

  private remover(name: string): () => void {
    return () => {
      this.setMember(name, null);
    };
  }

  private setMember(name: string, role: ProposalRole | null): void {
    const id = this.proposal?.id ?? "";
    void this.action.run(role === null ? msg(str`remove ${name}`) : msg(str`add ${name}`), () => new ObservingApi(this.api, this.site).setMember(id, name, role)).then((done) => {
      if (done) this.dispatchEvent(new CustomEvent("t-changed"));
    });
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-proposal-members": ProposalMembers;
  }
}
