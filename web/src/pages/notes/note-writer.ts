/** What lets an element write notes: the dialog, and news that somebody has written. */

import { html, type ReactiveController, type ReactiveControllerHost, type TemplateResult } from "lit";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import type { SiteShape } from "../../generated/api.js";
import type { NoteDraft } from "./notes-query.js";
import "./note-dialog.js";

/** A note is told as an event of this begin. */
const KIND = "note ";

export class NoteWriter implements ReactiveController {
  readonly draft: OpenSubject<NoteDraft>;

  /**
   * @param site whose news are heard
   * @param changed somebody has written, changed or removed a note there
   */
  constructor(
    host: ReactiveControllerHost & HTMLElement,
    site: () => string,
    private readonly changed: () => void,
  ) {
    this.draft = new OpenSubject<NoteDraft>(host);
    host.addController(this);
    new ConnectionStateController(host, (connection) => [
      connection.onMessage("event", (news) => {
        if (news.site === site() && news.kind.startsWith(KIND)) this.changed();
      }),
    ]);
  }

  hostConnected(): void {
    this.draft.close();
  }

  renderDialog(site: string, zone: string, detail: SiteShape | null): TemplateResult {
    return html`<t-note-dialog .site=${site} .zone=${zone} .detail=${detail} .draft=${this.draft.subject} @t-saved=${this.onSaved} @t-close=${this.draft.close}></t-note-dialog>`;
  }

  private readonly onSaved = (): void => {
    this.draft.close();
    // Also where the line to the hub is down, over which it would be told.
    this.changed();
  };
}

/** Whether an event is told because of a note: it stands at its own moment, and not where it was written. */
export function isNoteEvent({ kind }: { readonly kind: string }): boolean {
  return kind.startsWith(KIND);
}
