/** In place of every page while a role requires a second factor and its person has none. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { sessionContext } from "../../state/contexts.js";
import "../account/factors.js";

@customElement("t-first-factor")
export class FirstFactor extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      p {
        max-inline-size: 46rem;
      }
    `,
  ];

  private readonly session = new ContextStoreController(this, sessionContext);

  override render(): TemplateResult | typeof nothing {
    const person = this.session.store?.person ?? null;
    if (person === null) return nothing;
    return html`${renderPageHead(msg("Set up a second factor"), msg(str`Your role ${person.role} requires one before anything else.`))}
      <p>
        ${msg("With it, who learns your password is not in yet. Choose one of the two; you can add the other later. Keep the recovery codes that you are shown: they let you in if your phone or key is lost.")}
      </p>
      <t-account-factors></t-account-factors>
      <p><a href="/logout">${msg("Log out instead")}</a></p>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-first-factor": FirstFactor;
  }
}
