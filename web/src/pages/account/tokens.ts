/** Tokens for scripts: each with a part of one's rights, until a day. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { QuestionController } from "../../controllers/question.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { renderShownOnce } from "../../elements/forms/form-parts.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { renderRows } from "../../elements/layout/rows.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { permissionText } from "../../format/permissions.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { AccountApi } from "../../wire/account-api.js";
import type { Me, TokenShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import type { TokenWish } from "./token-form.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";
import "./token-form.js";

@customElement("t-account-tokens")
export class AccountTokens extends LitElement {
  static override styles = [base, sheets];

  @property({ attribute: false }) person: Me | null = null;
  @state() private made = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly rows = new LoadController<readonly TokenShape[]>(this);
  private readonly action = new ActionController(this);
  private readonly form = new OpenSubject<"new">(this);
  private readonly revoking = new QuestionController<TokenShape>(this, (row, action) =>
    action.run(msg("revoke it"), () => new AccountApi(this.api).revokeToken(row.id)).finally(this.rows.invalidate),
  );

  override willUpdate(): void {
    this.rows.load("tokens", () => new AccountApi(this.api).tokens());
  }

  override render(): TemplateResult {
    return html`<div class="head">
        <div>
          <h2>${msg("Tokens for scripts")}</h2>
          <p class="muted">${msg("A token holds a part of your rights, and never more than you have when it is used.")}</p>
        </div>
        <t-button ?hidden=${this.form.isOpen || this.made !== ""} @click=${this.form.opener("new")}>${msg("Make a token")}</t-button>
      </div>
      ${renderAdvice(this.action.problem)} ${this.made === "" ? nothing : this.renderShown()}
      ${this.form.isOpen
        ? html`<t-token-form
            .person=${this.person}
            .zone=${this.sites.store?.zone ?? "UTC"}
            ?busy=${this.action.busy}
            @t-wish=${this.createToken}
            @t-cancel=${this.closeForm}
          ></t-token-form>`
        : nothing}
      ${renderLoaded(this.rows, msg("the list of your tokens"), (rows) => this.renderList(rows))}
      ${renderQuestion(this.revoking, ({ name }) => ({
        heading: msg(str`Revoke ${name}?`),
        action: msg("Revoke it"),
        keep: msg("Keep it"),
        text: msg("Whatever uses it is refused from now on. It cannot be taken back."),
      }))}`;
  }

  private renderShown(): TemplateResult {
    return renderShownOnce(
      { label: msg("Token"), secret: this.made, done: msg("I have kept it"), onDone: this.closeSecret },
      msg(html`<strong>The token is made. It is not shown again:</strong> put it where your script reads it, and nowhere else.`),
      html`<p class="muted">${msg(html`A script sends it with each request as <code>Authorization: Bearer …</code>`)}</p>`,
    );
  }

  private renderList(rows: readonly TokenShape[]): unknown {
    if (rows.length === 0) return this.form.isOpen ? nothing : html`<p class="muted">${msg("You have none.")}</p>`;
    const zone = this.sites.store?.zone ?? "UTC";
    const now = Date.now() * 1000;
    return renderRows(
      rows,
      (row) => html`<li>
        <div>
          <span class="name">${row.name}</span>
          ${row.ends_us <= now ? html`<t-status kind="offline" word=${msg("ended", { id: "ended.token" })}></t-status>` : nothing}
          <div class="facts">
            <span>${msg(str`may ${permissionText(row.permissions)}`)}</span>
            <span>${msg(html`until <t-time .us=${row.ends_us} .zone=${zone}></t-time>`)}</span>
            <span>${msg(html`last used <t-time .us=${row.used_us} .zone=${zone}></t-time>`)}</span>
          </div>
        </div>
        <t-button label=${msg(str`Revoke the token ${row.name}`)} @click=${this.revoking.opener(row)}>${msg("Revoke…")}</t-button>
      </li>`,
    );
  }

  private readonly closeForm = (): void => {
    this.form.close();
    this.action.clear();
  };

  private readonly closeSecret = (): void => {
    this.made = "";
  };

  private readonly createToken = (event: CustomEvent<TokenWish>): void => {
    const { name, endsUs, permissions } = event.detail;
    void this.action
      .run(msg("make the token"), async () => {
        this.made = (await new AccountApi(this.api).makeToken(name, endsUs, permissions)).token;
      })
      .then((done) => {
        if (done) this.form.close();
        this.rows.invalidate();
      });
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-account-tokens": AccountTokens;
  }
}
