/** Somebody else acts on the device: interrupt them, or leave them to it. */

import { msg } from "@lit/localize";
import { html, nothing, type TemplateResult } from "lit";
import type { CommandClient } from "../../controllers/drive/command-client.js";
import type { CommandRequest } from "../../controllers/drive/command-machine.js";
import "../../elements/feedback/confirm.js";

/** @param asked - the newest of each command that is shown; the first that is blocked is asked about */
export function renderInterruptDialog(asked: readonly (CommandRequest | null)[], line: CommandClient | null): TemplateResult {
  const blocked = asked.find((request) => request !== null && request.phase === "refused" && request.blockedBy !== "") ?? null;
  const onLeave = (): void => {
    if (blocked !== null) line?.dismissBlocked(blocked);
  };
  const onInterrupt = (): void => {
    if (blocked !== null) line?.interruptOther(blocked);
  };
  return html`<t-confirm heading=${msg("Interrupt?")} action=${msg("Interrupt")} keep=${msg("Leave it")} ?open=${blocked !== null} @t-close=${onLeave} @t-confirm=${onInterrupt}>
    <p>${msg(html`${blocked === null ? nothing : blocked.message}. What you ask for would act against it.`)}</p>
  </t-confirm>`;
}
