/** Notes on the history page: loaded for the window, and written over a stretch that is dragged on a chart. */

import { msg } from "@lit/localize";
import { html, nothing, type ReactiveControllerHost } from "lit";
import type { SpanChange } from "../../elements/chart/chart-model.js";
import type { NoteShape, SiteShape } from "../../generated/api.js";
import { lengthOf, type TimeSpan } from "../../series/time-window.js";
import type { HubApi } from "../../wire/hub-api.js";
import { NotesApi } from "../notes/notes-api.js";
import { NoteWriter } from "../notes/note-writer.js";
import { NotesLoader } from "../notes/notes-loader.js";
import { draftAt } from "../notes/notes-query.js";
import "../../elements/forms/button.js";

const NONE: readonly NoteShape[] = [];

interface NotedWindow {
  readonly site: string;
  readonly span: TimeSpan;
  /** Where the cursor of the charts stands (µs); null for nowhere. */
  readonly cursorUs: number | null;
}

export class HistoryNotes {
  private loader: NotesLoader | null = null;
  private readonly writer: NoteWriter;
  /** The next stretch that is dragged on a chart gets a note, in place of filling the window. */
  private marking = false;

  constructor(
    private readonly host: ReactiveControllerHost & HTMLElement,
    private readonly shown: () => NotedWindow,
  ) {
    this.writer = new NoteWriter(host, () => shown().site, () => {
      this.loader?.invalidate();
      host.requestUpdate();
    });
  }

  get notes(): readonly NoteShape[] {
    return this.loader?.notes ?? NONE;
  }

  /** They could not be loaded; empty while they are. */
  get missingText(): string {
    return this.loader?.failed === true ? msg("Notes cannot be loaded now.") : "";
  }

  /** Call it from `willUpdate`. */
  loadNotes(api: HubApi, site: string, span: TimeSpan): void {
    this.loader ??= new NotesLoader(
      (of, query, signal) => new NotesApi(api, of).findNotes(query, signal),
      () => {
        this.host.requestUpdate();
      },
    );
    this.loader.loadNotes(site, span);
  }

  /** Whether a change of the window was the stretch for a note: then the window stays. */
  keepSpan({ span, settled }: SpanChange): boolean {
    const { fromUs, toUs } = this.shown().span;
    // What is dragged lies within the window; fingers and the wheel still move and zoom it.
    const dragged = settled && span.fromUs >= fromUs && span.toUs <= toUs && lengthOf(span) < toUs - fromUs;
    if (!this.marking || !dragged) return false;
    this.marking = false;
    this.writer.draft.open(draftAt(span.fromUs, span.toUs));
    return true;
  }

  renderButtons(detail: SiteShape | undefined): unknown {
    if (detail?.devices.some(({ rights }) => rights.includes("use")) !== true) return nothing;
    return html`<t-button kind="quiet" pressed=${this.marking ? "true" : "false"} title=${msg("The next stretch that you drag on a chart gets a note")} @click=${this.onMark}>${msg("Note a stretch")}</t-button>
      <t-button kind="quiet" title=${msg("A note over all that is shown, or at the cursor of a chart")} @click=${this.onNote}>${msg("Note")}</t-button>`;
  }

  renderDialog(site: string, detail: SiteShape | undefined): unknown {
    return detail === undefined ? nothing : this.writer.renderDialog(site, detail.zone, detail);
  }

  private readonly onMark = (): void => {
    this.marking = !this.marking;
    this.host.requestUpdate();
  };

  private readonly onNote = (event: Event): void => {
    const { span, cursorUs } = this.shown();
    this.marking = false;
    this.writer.draft.opener(cursorUs === null ? draftAt(span.fromUs, span.toUs) : draftAt(cursorUs))(event);
  };
}
