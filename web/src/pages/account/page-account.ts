/** One's own account: password, second factor, sessions, tokens for scripts. */

import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { levelAt, placeKey, seesOnlyPublic } from "../../state/rights.js";
import { sessionContext } from "../../state/contexts.js";
import type { Me } from "../../generated/api.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/language-choice.js";
import "./factors.js";
import "./provider.js";
import "./change-password.js";
import "./notification-rules.js";
import "./sessions.js";
import "./shown-units.js";
import "./tokens.js";

@customElement("t-page-account")
export class PageAccount extends LitElement {
  static override styles = [base, sheets];

  private readonly session = new ContextStoreController(this, sessionContext);

  override render(): TemplateResult | typeof nothing {
    const person = this.session.store?.person ?? null;
    if (person === null) return nothing;
    return html`
      ${renderPageHead(msg("Account"), msg(str`${person.name}, with the role ${person.role}: ${rightsText(person)}`))}
      <t-account-factors></t-account-factors>
      ${person.password ? html`<t-account-password class="sheet" .name=${person.name}></t-account-password>` : nothing}
      <t-account-provider class="sheet" ?only=${!person.password}></t-account-provider>
      ${seesOnlyPublic(person) ? nothing : html`<t-account-rules class="sheet"></t-account-rules>`}
      <section class="sheet">
        <h2>${msg("Language")}</h2>
        <p class="muted">${msg("Of the pages in this browser. Names, and what devices and the hub say, stay as they were written.")}</p>
        <div class="fields"><t-language-choice></t-language-choice></div>
      </section>
      <t-account-units class="sheet"></t-account-units>
      <t-account-sessions class="sheet"></t-account-sessions>
      <t-account-tokens class="sheet" .person=${person}></t-account-tokens>
    `;
  }
}

/** What a person may do, in one line. */
function rightsText(person: Me): string {
  if (person.admin) return msg("admin of the whole hub.");
  if (person.permissions.length === 0) return msg("you see what is public.");
  const places = new Map(person.permissions.map((permission) => [placeKey(permission), permission]));
  const words = [...places.values()].map((place) => {
    const what = place.site === "*" ? msg("every site") : place.device === "*" ? place.site : `${place.site} ${place.device}`;
    return `${levelAt(person.permissions, place)} ${what}`;
  });
  return `${words.join(", ")}.`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-account": PageAccount;
  }
}
