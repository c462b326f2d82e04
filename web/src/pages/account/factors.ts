/** One's second factors side by side: codes from an app, and passkeys. */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import { sheets } from "../../elements/layout/page-sections.js";
import type { PasskeyList } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import { AccountApi } from "../../wire/account-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import "./passkeys.js";
import "./second-factor.js";

@customElement("t-account-factors")
export class AccountFactors extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      .two {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(min(26rem, 100%), 1fr));
        align-items: start;
        gap: var(--t-space-4);
      }
    `,
  ];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly factors = new LoadController<PasskeyList>(this);

  override willUpdate(): void {
    this.factors.load("factors", () => new AccountApi(this.api).passkeys());
  }

  override render(): TemplateResult {
    return html`${renderLoaded(
      this.factors,
      msg("your second factors"),
      (list) => html`<div class="two">
        <t-account-factor class="sheet" .active=${list.codes} @t-changed=${this.factors.invalidate}></t-account-factor>
        <t-account-passkeys class="sheet" .list=${list} @t-changed=${this.factors.invalidate}></t-account-passkeys>
      </div>`,
    )}`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-account-factors": AccountFactors;
  }
}
