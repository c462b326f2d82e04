/** Where one is signed in, and the end of it. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { renderRows } from "../../elements/layout/rows.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { browserName } from "../../format/user-agent.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { AccountApi } from "../../wire/account-api.js";
import type { SessionShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";

/** Tells what ends all others from what ends one. */
const OTHERS = "others";

@customElement("t-account-sessions")
export class AccountSessions extends LitElement {
  static override styles = [base, sheets];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly rows = new LoadController<readonly SessionShape[]>(this);
  private readonly action = new ActionController(this);

  override willUpdate(): void {
    this.rows.load("sessions", () => new AccountApi(this.api).sessions());
  }

  override render(): TemplateResult {
    const others = this.rows.value?.filter((row) => !row.this).length ?? 0;
    const { problem, doneText: done, runningKey: under } = this.action;
    return html`<div class="head">
        <h2>${msg("Sessions")}</h2>
        ${others < 2
          ? nothing
          : html`<t-button ?busy=${under === OTHERS} @click=${this.endOthers}>${msg("End all others")}</t-button>`}
      </div>
      ${renderAdvice(problem)}
      <p class="visually-hidden" role="status">${done}</p>
      ${renderLoaded(this.rows, msg("the list of your sessions"), (rows) => renderRows(rows, (row) => this.renderRow(row)))}`;
  }

  private renderRow(row: SessionShape): TemplateResult {
    const zone = this.sites.store?.zone ?? "UTC";
    return html`<li>
      <div>
        <span class="name" title=${row.agent}>${browserName(row.agent)}</span>
        ${row.this ? html`<t-status kind="ok" word=${msg("this one")}></t-status>` : nothing}
        <div class="facts">
          <span>${row.address === "" ? msg("from an unknown address") : msg(str`from ${row.address}`, { id: "from.address" })}</span>
          <span>${msg(html`since <t-time .us=${row.created_us} .zone=${zone}></t-time>`)}</span>
          <span>${msg(html`last used <t-time .us=${row.used_us} .zone=${zone}></t-time>`)}</span>
        </div>
      </div>
      ${row.this
        ? nothing
        : html`<t-button
            label=${msg(str`End this: the session of ${browserName(row.agent)} from ${row.address}`)}
            ?busy=${this.action.runningKey === row.id}
            @click=${this.sessionEnder(row)}
            >${msg("End this")}</t-button
          >`}
    </li>`;
  }

  private sessionEnder(row: SessionShape): () => void {
    return () => {
      void this.endSession(row);
    };
  }

  private async endSession(row: SessionShape): Promise<void> {
    const api = new AccountApi(this.api);
    await this.action.run(msg("end this session"), () => api.endSession(row.id), msg("The session is ended."), row.id);
    this.rows.invalidate();
  }

  private readonly endOthers = (): void => {
    const api = new AccountApi(this.api);
    void this.action.run(msg("end them"), () => api.endOtherSessions(), msg("All other sessions are ended."), OTHERS).then(this.rows.invalidate);
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-account-sessions": AccountSessions;
  }
}
