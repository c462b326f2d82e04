/** One's passkeys: make, list and remove them. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { focusInside } from "../../elements/base/focus.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { renderFormActions } from "../../elements/forms/form-parts.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { renderRows } from "../../elements/layout/rows.js";
import { browserName } from "../../format/user-agent.js";
import type { PasskeyList, PasskeyShape } from "../../generated/api.js";
import { apiContext, sessionContext, sitesContext } from "../../state/contexts.js";
import { AccountApi } from "../../wire/account-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { hasPasskeys } from "../../wire/passkeys.js";
import { renderRecoveryCodes } from "./recovery-codes.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../../elements/values/time.js";

/** @fires t-changed one was made or removed: the list is old */
@customElement("t-account-passkeys")
export class AccountPasskeys extends LitElement {
  static override styles = [base, sheets];

  @property({ attribute: false }) list: PasskeyList | null = null;
  @state() private adding = false;
  @state() private missing = false;
  /** The id of the one that is called otherwise now. */
  @state() private renaming = "";
  @state() private recovery: readonly string[] = [];
  @query("#passkey-name") private readonly name!: HTMLInputElement | null;
  @query("#new-name") private readonly newName!: HTMLInputElement | null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly action = new ActionController(this);

  override render(): TemplateResult {
    const rows = this.list?.passkeys ?? [];
    const on = rows.length > 0 || this.recovery.length > 0;
    return html`<div class="head">
        <h2>${msg("Passkeys")}</h2>
        <t-status kind=${on ? "ok" : "unknown"} word=${on ? msg("on") : msg("off")}></t-status>
      </div>
      ${renderAdvice(this.action.problem)}
      ${this.recovery.length > 0 ? renderRecoveryCodes(this.recovery, this.onKept) : this.renderList(rows)}`;
  }

  private renderList(rows: readonly PasskeyShape[]): TemplateResult {
    return html`<p>
        ${msg("A key that your phone, your computer or a security key keeps. It signs you in only at this hub's own address, so nobody can get it out of you on another page.")}
      </p>
      ${rows.length === 0 ? nothing : renderRows(rows, (row) => this.renderRow(row))} ${this.renderForm()}`;
  }

  private renderRow(row: PasskeyShape): TemplateResult {
    if (row.id === this.renaming) return this.renderRename(row);
    const zone = this.sites.store?.zone ?? "UTC";
    return html`<li>
      <div>
        <span class="name">${row.name}</span>
        <div class="facts">
          <span>${msg(str`for ${row.host}`, { id: "for.host" })}</span>
          <span>${msg(html`since <t-time .us=${row.created_us} .zone=${zone}></t-time>`)}</span>
          <span>${row.used_us === 0 ? msg("not used yet") : msg(html`last used <t-time .us=${row.used_us} .zone=${zone}></t-time>`)}</span>
        </div>
      </div>
      <div class="actions">
        <t-button label=${msg(str`Rename the passkey ${row.name}`)} @click=${this.renameOpener(row)}>${msg("Rename")}</t-button>
        <t-button label=${msg(str`Remove the passkey ${row.name}`)} ?busy=${this.action.runningKey === row.id} @click=${this.remover(row)}>${msg("Remove")}</t-button>
      </div>
    </li>`;
  }

  private renderRename(row: PasskeyShape): TemplateResult {
    return html`<li>
      <form class="fields" novalidate @submit=${this.onRename}>
        <t-field label=${msg("New name of the passkey")} error=${this.missing ? msg("Enter a name.") : ""}>
          <input id="new-name" autocomplete="off" maxlength="100" .value=${row.name} required />
        </t-field>
        ${renderFormActions({ submit: msg("Rename it"), busy: this.action.runningKey === "rename", cancel: this.closeRename })}
      </form>
    </li>`;
  }

  private renderForm(): TemplateResult {
    if (this.list?.possible === false || !hasPasskeys()) {
      return html`<p class="muted">
        ${msg("Browsers make passkeys only over HTTPS, and for a name: open this hub by a name (such as hub.example) and not by an IP address.")}
      </p>`;
    }
    if (!this.adding) {
      return html`<div class="actions"><t-button kind=${this.list?.passkeys.length === 0 ? "primary" : "plain"} @click=${this.openForm}>${msg("Add a passkey")}</t-button></div>`;
    }
    return html`<form class="fields" novalidate @submit=${this.onSubmit}>
      <t-field label=${msg("Name of the passkey")} hint=${msg("So that you know it again, such as the device that keeps it.")} error=${this.missing ? msg("Enter a name.") : ""}>
        <input id="passkey-name" autocomplete="off" maxlength="100" .value=${browserName(navigator.userAgent)} required />
      </t-field>
      ${renderFormActions({ submit: msg("Make it"), busy: this.action.runningKey === "add", cancel: this.closeForm })}
    </form>`;
  }

  private readonly openForm = (): void => {
    this.adding = true;
    this.missing = false;
    this.action.clear();
    void focusInside(this, "input");
  };

  private readonly closeForm = (): void => {
    this.adding = false;
    void focusInside(this, ".actions t-button");
  };

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    const name = this.name?.value.trim() ?? "";
    this.missing = name === "";
    if (!this.missing) void this.addPasskey(name);
  };

  private async addPasskey(name: string): Promise<void> {
    const done = await this.action.run(
      msg("add a passkey"),
      async () => {
        this.recovery = await new AccountApi(this.api).addPasskey(name);
      },
      "",
      "add",
    );
    if (!done) return;
    this.adding = false;
    this.dispatchEvent(new CustomEvent("t-changed"));
    // Codes are looked at first: with the first factor another page may take the place of this one.
    if (this.recovery.length === 0) this.closeForm();
  }

  private renameOpener(row: PasskeyShape): () => void {
    return () => {
      this.renaming = row.id;
      this.missing = false;
      this.action.clear();
      void focusInside(this, "#new-name");
    };
  }

  private readonly closeRename = (): void => {
    this.renaming = "";
    void focusInside(this, "li t-button");
  };

  private readonly onRename = (event: SubmitEvent): void => {
    event.preventDefault();
    const [id, name] = [this.renaming, this.newName?.value.trim() ?? ""];
    this.missing = name === "";
    if (this.missing) return;
    void this.action.run(msg("rename this passkey"), () => new AccountApi(this.api).renamePasskey(id, name), "", "rename").then((done) => {
      if (!done) return;
      this.closeRename();
      this.dispatchEvent(new CustomEvent("t-changed"));
    });
  };

  private remover(row: PasskeyShape): () => void {
    return () => {
      void this.action.run(msg("remove this passkey"), () => new AccountApi(this.api).removePasskey(row.id), "", row.id).then(async (done) => {
        if (!done) return;
        this.dispatchEvent(new CustomEvent("t-changed"));
        await this.session.store?.refresh().catch(() => undefined);
      });
    };
  }

  private readonly onKept = (): void => {
    this.recovery = [];
    void this.session.store?.refresh().catch(() => undefined);
    void focusInside(this, ".actions t-button");
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-account-passkeys": AccountPasskeys;
  }
}
