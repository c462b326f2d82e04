/**
 * Lets a screen in: its token stands behind the address's "#", which no browser sends to anybody, and
 * goes into a cookie that no script can read. The address is empty again before anything else is loaded.
 */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { html, LitElement, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { doorway } from "../../elements/layout/sign-in-layout.js";
import { apiContext, sessionContext } from "../../state/contexts.js";
import { returnPath } from "../../state/router.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/feedback/loading.js";
import "../../elements/forms/button.js";

@customElement("t-page-display")
export class PageDisplay extends LitElement {
  static override styles = [base, doorway];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly action = new ActionController(this);
  private token = "";
  /** What it shows first: a board, for example. */
  private next = "/home";

  override connectedCallback(): void {
    super.connectedCallback();
    this.token = location.hash.slice(1);
    this.next = returnPath(location.search, location.origin);
    history.replaceState(null, "", "/display");
  }

  override firstUpdated(): void {
    // An address that somebody else wrote must not end a person's session: they are asked.
    if (this.token !== "" && !this.isSomebody) void this.enter();
  }

  private get isSomebody(): boolean {
    const person = this.session.store?.person ?? null;
    return person !== null && person.role !== "display";
  }

  override render(): TemplateResult {
    const { problem } = this.action;
    if (this.token !== "" && this.isSomebody) {
      return html`<div class="sheet">
        <h1>${msg("Make this browser a display?")}</h1>
        <p>${msg("It shows some sites from then on, and you are not signed in here any more.")}</p>
        ${renderAdvice(problem)}
        <t-button kind="primary" ?busy=${this.action.busy} @click=${this.enter}>${msg("Make it a display")}</t-button>
        <p><a href="/">${msg("Stay signed in")}</a></p>
      </div>`;
    }
    if (this.token !== "" && problem === null) return html`<t-loading what=${msg("Opening the display")}></t-loading>`;
    return html`<div class="sheet">
      <h1>${msg("A display")}</h1>
      ${renderAdvice(problem)}
      <p>${msg("Open the address that was shown when the display was made (Admin, People, Displays), with all that stands behind its “#”.")}</p>
      <p><a href="/login">${msg("Sign in")}</a></p>
    </div>`;
  }

  private readonly enter = async (): Promise<void> => {
    const done = await this.action.run(msg("open the display"), () =>
      this.api.request("POST", "/api/displays/open", { token: this.token }),
    );
    // Anew, so that whatever was shown for somebody else before is gone.
    if (done) location.replace(this.next);
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-display": PageDisplay;
  }
}
