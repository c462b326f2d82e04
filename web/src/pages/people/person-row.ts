/** One person: how they stand, and unfolded what an admin can do. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { QuestionController } from "../../controllers/question.js";
import { base } from "../../elements/base/base-style.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { passwordRules, passwordProblem } from "../../format/password-rules.js";
import { apiContext } from "../../state/contexts.js";
import type { PersonShape, RoleShape } from "../../generated/api.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";

/** What is asked about before it is done. */
type PersonQuestion = "remove" | "factor" | "disable" | "provider";

/**
 * @fires t-toggle it is to be unfolded or folded
 * @fires t-changed something was done: the list is old
 */
@customElement("t-person-row")
export class PersonSection extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      :host {
        display: block;
        padding-block: var(--t-space-3);
      }
      .line {
        display: grid;
        grid-template-columns: minmax(8rem, 1fr) 9rem minmax(0, 2fr) auto;
        align-items: center;
        gap: var(--t-space-1) var(--t-space-4);
      }
      .more {
        display: grid;
        gap: var(--t-space-4);
        padding: var(--t-space-4) 0 var(--t-space-2);
      }
      form {
        display: flex;
        flex-wrap: wrap;
        align-items: start;
        gap: var(--t-space-2);
      }
      form t-field {
        flex: 0 1 18rem;
      }
      /* Level with the control, below the height of its label. */
      form t-button {
        margin-block-start: calc(var(--t-size-s) * 1.45 + var(--t-space-1));
      }
      @media (max-width: 45rem) {
        .line {
          grid-template-columns: minmax(0, 1fr) auto;
        }
        .facts {
          grid-column: 1 / -1;
        }
        .edit {
          grid-column: 2;
          grid-row: 1 / 3;
        }
        form t-field {
          flex: 1 1 100%;
        }
        form t-button {
          margin: 0;
        }
      }
    `,
  ];

  @property({ attribute: false }) row: PersonShape | null = null;
  @property({ attribute: false }) roles: readonly RoleShape[] = [];
  @property() zone = "UTC";
  /** It is the admin who looks at it. */
  @property({ type: Boolean }) self = false;
  @property({ type: Boolean }) open = false;
  @state() private trouble = "";
  @query("#role") private readonly roleBox!: HTMLSelectElement;
  @query("#password") private readonly password!: HTMLInputElement;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);
  private readonly question = new QuestionController<PersonQuestion>(this, (asked) => this.performAsked(asked), this.action);

  override render(): TemplateResult | typeof nothing {
    const { row } = this;
    if (row === null) return nothing;
    return html`<div class="line">
        <span class="name">${row.name}${this.self ? html` <span class="muted">${msg("(you)")}</span>` : nothing}</span>
        <span><span class="chip">${row.role}</span></span>
        <div class="facts">
          ${row.disabled ? html`<t-status kind="offline" word=${msg("disabled")}></t-status>` : nothing}
          <t-status
            kind=${row.sessions > 0 ? "online" : "unknown"}
            word=${row.sessions > 0 ? row.sessions > 1 ? msg(str`signed in ${String(row.sessions)} times`) : msg("signed in") : msg("not signed in")}
          ></t-status>
          <span>${row.factor ? msg("second factor on") : msg("second factor off")}</span>
          <span>${row.used_us === 0 ? msg("never here") : msg(html`last here <t-time short .us=${row.used_us} .zone=${this.zone}></t-time>`)}</span>
        </div>
        <t-button
          class="edit"
          label=${this.open ? msg(str`Fold ${row.name}`) : msg(str`Edit ${row.name}`)}
          pressed=${this.open ? "true" : "false"}
          @click=${this.toggle}
          >${this.open ? msg("Close") : msg("Edit")}</t-button
        >
      </div>
      ${this.open ? this.renderDetails(row) : nothing} ${renderQuestion(this.question, (asked) => {
        const { heading, action, text } = WORDS[asked];
        return { heading: heading.replace("{}", row.name), action, text };
      })}`;
  }

  private renderDetails(row: PersonShape): TemplateResult {
    const { problem, doneText: done } = this.action;
    return html`<div class="more">
      ${this.question.isOpen ? nothing : renderAdvice(problem)}
      <form novalidate @submit=${this.changeRole}>
        <t-field label=${msg("Role")} hint=${msg("They are signed out, and have it when they sign in again.")}>
          <select id="role">
            ${renderOptions(this.roles.map(({ name }) => name), row.role)}
          </select>
        </t-field>
        <t-button type="submit" ?busy=${this.action.runningKey === "role"}>${msg("Give this role")}</t-button>
      </form>
      <form novalidate @submit=${this.changePassword}>
        <t-field label=${msg("New password")} hint=${msg("All their sessions and their tokens for scripts end with it.")} error=${this.trouble}>
          <input id="password" type="password" autocomplete="new-password" />
        </t-field>
        <t-button type="submit" ?busy=${this.action.runningKey === "password"}>${msg("Set this password")}</t-button>
      </form>
      <div class="actions">
        <t-button ?disabled=${row.sessions === 0} ?busy=${this.action.runningKey === "sessions"} @click=${this.endSessions}
          >${msg("End all sessions")}</t-button
        >
        ${row.provider ? html`<t-button @click=${this.question.opener("provider")}>${msg("Disconnect from the provider…")}</t-button>` : nothing}
        ${row.factor ? html`<t-button @click=${this.question.opener("factor")}>${msg("Remove the second factor…")}</t-button>` : nothing}
        ${row.disabled
          ? html`<t-button ?busy=${this.action.runningKey === "enable"} @click=${this.enable}>${msg("Enable")}</t-button>`
          : html`<t-button @click=${this.question.opener("disable")}>${msg("Disable…")}</t-button>`}
        <t-button @click=${this.question.opener("remove")}>${msg("Remove…")}</t-button>
        <span class="said" role="status">${done}</span>
      </div>
    </div>`;
  }

  private readonly toggle = (): void => {
    this.trouble = "";
    this.action.clear();
    this.dispatchEvent(new CustomEvent("t-toggle"));
  };

  private performAsked(asked: PersonQuestion): Promise<boolean> {
    const { id, name } = this.row ?? { id: "", name: "" };
    const api = new AdminApi(this.api);
    switch (asked) {
      case "remove":
        return this.runAction(msg(str`remove ${name}`), () => api.removePerson(id), "");
      case "factor":
        return this.runAction(msg("remove the second factor"), () => api.removeFactor(id), msg("The second factor is removed."));
      case "provider":
        return this.runAction(msg("disconnect from the provider"), () => api.disconnectPerson(id), msg("Disconnected."));
      case "disable":
        return this.runAction(msg(str`disable ${name}`), () => api.changePerson(id, { disabled: true }), msg("Disabled."));
    }
  }

  private readonly enable = (): void => {
    const id = this.row?.id ?? "";
    void this.runAction(msg("enable this person"), () => new AdminApi(this.api).changePerson(id, { disabled: false }), msg("Enabled."), "enable");
  };

  private readonly endSessions = (): void => {
    const id = this.row?.id ?? "";
    void this.runAction(msg("end the sessions"), () => new AdminApi(this.api).endSessions(id), msg("All sessions are ended."), "sessions");
  };

  private readonly changeRole = (event: SubmitEvent): void => {
    event.preventDefault();
    const id = this.row?.id ?? "";
    const role = this.roleBox.value;
    if (role === this.row?.role) return;
    void this.runAction(msg("change the role"), () => new AdminApi(this.api).changePerson(id, { role }), msg(str`The role is ${role} now.`), "role");
  };

  private readonly changePassword = (event: SubmitEvent): void => {
    event.preventDefault();
    const { row } = this;
    if (row === null) return;
    const password = this.password.value;
    this.trouble = passwordProblem(passwordRules(password, row.name, password));
    if (this.trouble !== "") return;
    const sendPassword = (): Promise<unknown> => new AdminApi(this.api).changePerson(row.id, { password });
    void this.runAction(msg("set the password"), sendPassword, msg("The password is set."), "password").then((done) => {
      if (done) this.password.value = "";
    });
  };

  private async runAction(asked: string, action: () => Promise<unknown>, done: string, key = asked): Promise<boolean> {
    if (!(await this.action.run(asked, action, done, key))) return false;
    this.dispatchEvent(new CustomEvent("t-changed"));
    return true;
  }
}

const WORDS: Readonly<Record<PersonQuestion, { heading: string; text: string; action: string }>> = {
  remove: {
    heading: msg("Remove {}?"),
    text: msg("Their sessions and tokens end at once. What they did stays in the audit log. It cannot be taken back."),
    action: msg("Remove"),
  },
  factor: {
    heading: msg("Remove the second factor of {}?"),
    text: msg("From then on the password alone lets them in. Do this only when you are sure who asked for it."),
    action: msg("Remove it"),
  },
  provider: {
    heading: msg("Disconnect {} from the provider of sign-ins?"),
    text: msg("Their sessions end, and they sign in with their password here. Whoever comes from the provider then is somebody new."),
    action: msg("Disconnect"),
  },
  disable: {
    heading: msg("Disable {}?"),
    text: msg("Their sessions end at once, and they cannot sign in until somebody enables them again."),
    action: msg("Disable"),
  },
};

declare global {
  interface HTMLElementTagNameMap {
    "t-person-row": PersonSection;
  }
}
