/** Who has control of what is driven by hand, and the buttons that take it, free it and hand it over. */

import { html, type TemplateResult } from "lit";
import type { DriveSession } from "../../controllers/drive/drive-session.js";
import "../../elements/drive/lease-line.js";

/** @param forces - the person is an admin, who may take control from whoever has left it */
export function renderLease(session: DriveSession, { stopped, forces }: { readonly stopped: boolean; readonly forces: boolean }): TemplateResult {
  const { state } = session.lease;
  const take = (): void => {
    session.takeControl();
  };
  const free = (): void => {
    session.releaseControl();
  };
  const answer = ({ detail }: CustomEvent<boolean>): void => {
    session.answerRequest(detail);
  };
  const force = (): void => {
    session.forceTakeover();
  };
  return html`<t-lease
    .kind=${state.kind}
    .holder=${state.kind === "other" || state.kind === "waiting" ? state.holder : ""}
    .rival=${state.kind === "mine" ? (state.rival?.who ?? "") : ""}
    .answer=${session.answerRemainingMs}
    .forceable=${state.kind === "other" && state.forceable && forces}
    .remains=${session.remainingMs}
    .online=${session.online}
    .stopped=${stopped}
    @t-take=${take}
    @t-free=${free}
    @t-answer=${answer}
    @t-force=${force}
  ></t-lease>`;
}
