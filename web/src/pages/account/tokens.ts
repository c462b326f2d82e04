/** Tokens for scripts: each with a part of one's rights, until a day. */

import { consume } from "@lit/context";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { adviceFor } from "../../format/error-advice.js";
import { permissionText } from "../../format/permissions.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { AccountApi } from "../../wire/account-api.js";
import type { TokenRow } from "../../wire/admin-types.js";
import type { Person } from "../../wire/api-types.js";
import type { HubApi } from "../../wire/hub-api.js";
import type { TokenWish } from "./token-form.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/confirm.js";
import "../../elements/forms/copy-text.js";
import "../../elements/feedback/loading.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";
import "./token-form.js";

@customElement("t-account-tokens")
export class AccountTokens extends LitElement {
  static override styles = [base, sheets];

  @property({ attribute: false }) person: Person | null = null;
  @state() private making = false;
  @state() private made = "";
  @state() private revoking: TokenRow | null = null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly rows = new LoadController<readonly TokenRow[]>(this);
  private readonly action = new ActionController(this);

  override willUpdate(): void {
    this.rows.load("tokens", () => new AccountApi(this.api).tokens());
  }

  override render(): TemplateResult {
    const { problem } = this.action;
    return html`<div class="head">
        <div>
          <h2>Tokens for scripts</h2>
          <p class="muted">A token holds a part of your rights, and never more than you have when it is used.</p>
        </div>
        ${this.making || this.made !== "" ? nothing : html`<t-button @click=${this.openForm}>Make a token</t-button>`}
      </div>
      ${problem === null || this.revoking !== null
        ? nothing
        : renderAdvice(problem)}
      ${this.made === "" ? nothing : this.renderShown()}
      ${this.making
        ? html`<t-token-form
            .person=${this.person}
            .zone=${this.sites.store?.zone ?? "UTC"}
            ?busy=${this.action.busy}
            @t-wish=${this.createToken}
            @t-cancel=${this.closeForm}
          ></t-token-form>`
        : nothing}
      ${this.renderList()} ${this.renderQuestion()}`;
  }

  private renderShown(): TemplateResult {
    return html`<div class="fields" style="max-inline-size: 46rem">
      <p><strong>The token is made. It is not shown again:</strong> put it where your script reads it, and nowhere else.</p>
      <t-copy label="Token" .text=${this.made}></t-copy>
      <p class="muted">A script sends it with each request as <code>Authorization: Bearer …</code></p>
      <div class="actions"><t-button kind="primary" @click=${this.closeSecret}>I have kept it</t-button></div>
    </div>`;
  }

  private renderList(): unknown {
    const { result, value } = this.rows;
    if (result.state === "failed") {
      return renderAdvice(adviceFor(result.error, "the list of your tokens"), this.retry);
    }
    if (value === undefined) return html`<t-loading what="Loading your tokens"></t-loading>`;
    if (value.length === 0) return this.making ? nothing : html`<p class="muted">You have none.</p>`;
    const zone = this.sites.store?.zone ?? "UTC";
    const now = Date.now() * 1000;
    return html`<ul class="rows">
      ${repeat(
        value,
        (row) => row.id,
        (row) => html`<li>
          <div>
            <span class="name">${row.name}</span>
            ${row.ends_us <= now ? html`<t-status kind="offline" word="ended"></t-status>` : nothing}
            <div class="facts">
              <span>may ${permissionText(row.permissions)}</span>
              <span>until <t-time .us=${row.ends_us} .zone=${zone}></t-time></span>
              <span>last used <t-time .us=${row.used_us} .zone=${zone}></t-time></span>
            </div>
          </div>
          <t-button label=${`Revoke the token ${row.name}`} @click=${this.revokeAsker(row)}>Revoke…</t-button>
        </li>`,
      )}
    </ul>`;
  }

  private renderQuestion(): TemplateResult {
    const row = this.revoking;
    return html`<t-confirm
      heading=${`Revoke ${row?.name ?? ""}?`}
      action="Revoke it"
      keep="Keep it"
      ?open=${row !== null}
      ?busy=${this.action.busy}
      .problem=${row === null ? null : this.action.problem}
      @t-confirm=${this.revoke}
      @t-close=${this.closeQuestion}
      ><p>Whatever uses it is refused from now on. It cannot be taken back.</p></t-confirm
    >`;
  }

  private revokeAsker(row: TokenRow): () => void {
    return () => {
      this.action.clear();
      this.revoking = row;
    };
  }

  private readonly openForm = (): void => {
    this.making = true;
    this.action.clear();
  };

  private readonly closeForm = (): void => {
    this.making = false;
    this.action.clear();
  };

  private readonly closeSecret = (): void => {
    this.made = "";
  };

  private readonly closeQuestion = (): void => {
    this.revoking = null;
    this.action.clear();
  };

  private readonly retry = (): void => {
    this.rows.invalidate();
  };

  private readonly createToken = (event: CustomEvent<TokenWish>): void => {
    const { name, endsUs, permissions } = event.detail;
    void this.action
      .run("make the token", async () => {
        this.made = (await new AccountApi(this.api).makeToken(name, endsUs, permissions)).token;
      })
      .then((done) => {
        if (!done) return;
        this.making = false;
        this.retry();
      });
  };

  private readonly revoke = (): void => {
    const row = this.revoking;
    if (row === null) return;
    void this.action.run("revoke it", () => new AccountApi(this.api).revokeToken(row.id)).then((done) => {
      if (!done) return;
      this.revoking = null;
      this.retry();
    });
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-account-tokens": AccountTokens;
  }
}
