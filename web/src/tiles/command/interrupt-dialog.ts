/** Somebody else acts on the device: interrupt them, or leave them to it. */

import { html, nothing, type TemplateResult } from "lit";
import type { CommandLine } from "../../controllers/drive/command-client.js";
import type { Asked } from "../../controllers/drive/command-machine.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/dialog.js";

/** @param asked - the newest of each command that is shown; the first that is blocked is asked about */
export function renderInterruptDialog(asked: readonly (Asked | null)[], line: CommandLine | null): TemplateResult {
  const blocked = asked.find((one) => one !== null && one.phase === "refused" && one.blockedBy !== "") ?? null;
  const leave = (): void => {
    if (blocked !== null) line?.dismissBlocked(blocked);
  };
  const interrupt = (): void => {
    if (blocked !== null) line?.interruptOther(blocked);
  };
  return html`<t-dialog heading="Interrupt?" ?open=${blocked !== null} @t-close=${leave}>
    <p>${blocked === null ? nothing : blocked.message}. What you ask for would act against it.</p>
    <t-button slot="actions" @click=${leave}>Leave it</t-button>
    <t-button slot="actions" kind="danger" @click=${interrupt}>Interrupt</t-button>
  </t-dialog>`;
}
