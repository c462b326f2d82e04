/** Back from the provider of sign-ins: hands the hub what it was sent back with, and goes on. */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { base } from "../../elements/base/base-style.js";
import { doorway } from "../../elements/layout/sign-in-layout.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { apiContext, routerContext, sessionContext } from "../../state/contexts.js";
import type { Router } from "../../state/router.js";
import type { Session } from "../../state/session.js";
import type { HubApi } from "../../wire/hub-api.js";
import "../../elements/feedback/loading.js";

@customElement("t-page-oidc")
export class PageOidc extends LitElement {
  static override styles = [
    base,
    doorway,
    css`
      p {
        margin: 0;
      }
    `,
  ];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  @consume({ context: routerContext }) private readonly router!: Router;
  @consume({ context: sessionContext }) private readonly session!: Session;
  private readonly action = new ActionController(this);

  override firstUpdated(): void {
    const said = new URLSearchParams(this.router.search);
    // The code is good once; nobody is to find it in this browser's history.
    window.history.replaceState(null, "", "/oidc");
    void this.action.run(msg("sign you in"), async () => {
      const { returns } = await this.api.finishOidc({
        state: said.get("state") ?? "-",
        code: said.get("code") ?? "",
        iss: said.get("iss") ?? "",
        error: said.get("error") ?? "",
      });
      await this.session.refresh();
      this.router.replace(returns);
    });
  }

  override render(): TemplateResult {
    if (this.action.problem === null) return html`<t-loading what=${msg("Signing in")}></t-loading>`;
    return html`<div class="sheet">
      ${renderAdvice(this.action.problem)}
      <p><a href="/">${msg("Back")}</a></p>
    </div>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-oidc": PageOidc;
  }
}
