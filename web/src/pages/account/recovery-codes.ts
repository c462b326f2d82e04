/** The recovery codes, shown once. */

import { msg } from "@lit/localize";
import { html, type TemplateResult } from "lit";
import "../../elements/forms/button.js";
import "../../elements/forms/copy-text.js";

/** @param onKept the person has them now, and they are forgotten here */
export function renderRecoveryCodes(codes: readonly string[], onKept: () => void): TemplateResult {
  // A file without a server: the codes never leave this page but by the person's hand.
  const url = `data:text/plain;charset=utf-8,${encodeURIComponent(`${codes.join("\n")}\n`)}`;
  return html`<p>
      ${msg("The second factor is on. If your phone or key is lost, each of these codes lets you in once. They are not shown again: keep them where your phone is not.")}
    </p>
    <t-copy label=${msg("Recovery codes")} .text=${codes.join("\n")}></t-copy>
    <div class="actions">
      <a download="talaia-recovery-codes.txt" href=${url}>${msg("Download as a file")}</a>
      <t-button kind="primary" @click=${onKept}>${msg("I have kept them")}</t-button>
    </div>`;
}
