/** Tells a person that somebody who knows their password has tried codes, until they say they have read it. */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { apiContext, sessionContext, sitesContext } from "../../state/contexts.js";
import { AccountApi } from "../../wire/account-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import "../../elements/feedback/banner.js";
import "../../elements/forms/button.js";
import "../../elements/values/time.js";

@customElement("t-code-alert")
export class CodeAlert extends LitElement {
  static override styles = [base];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly action = new ActionController(this);

  override render(): TemplateResult | typeof nothing {
    const lockedUs = this.session.store?.person?.codes_locked_us ?? 0;
    if (lockedUs === 0) return nothing;
    return html`<t-banner kind="bad"
      >${msg(html`Many wrong codes were given for your account, the last <t-time .us=${lockedUs} .zone=${this.sites.store?.zone ?? "UTC"}></t-time>, by somebody who knows your password. If it was not you, <a href="/account">change your password</a>.`)}
      <t-button ?busy=${this.action.busy} @click=${this.onSeen}>${msg("I have read it")}</t-button>
      ${this.action.problem === null ? nothing : html`<strong>${this.action.problem.what}</strong>`}</t-banner
    >`;
  }

  private readonly onSeen = (): void => {
    void this.action.run(msg("take this"), async () => {
      await new AccountApi(this.api).seeAlert();
      await this.session.store?.refresh();
    });
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-code-alert": CodeAlert;
  }
}
