/** The notes of a span, asked again when the span leaves what is known, or when somebody has written. */

import type { NoteList, NoteShape } from "../../generated/api.js";
import { lengthOf, type TimeSpan } from "../../series/time-window.js";
import { LatestRequest } from "../history/data/latest-request.js";
import { notesSpanQuery } from "./notes-query.js";

interface NotesQuestion {
  readonly site: string;
  readonly span: TimeSpan;
  /** Counts the times that somebody has written. */
  readonly edition: number;
}

const LIMIT = 1000;
const NONE: readonly NoteShape[] = [];

export class NotesLoader {
  /** Another list only when something of it is new. */
  notes: readonly NoteShape[] = NONE;
  private edition = 0;
  private readonly asker: LatestRequest<NotesQuestion, NoteList>;

  /** @param find asks the hub, as `NotesApi.findNotes` */
  constructor(find: (site: string, query: string, signal: AbortSignal) => Promise<NoteList>, changed: () => void) {
    this.asker = new LatestRequest<NotesQuestion, NoteList>({
      fetch: ({ site, span }, signal) => find(site, notesSpanQuery(span, LIMIT), signal),
      isStillUseful: (running, next) => running.site === next.site,
      onAnswer: ({ notes }) => {
        // Charts that got another list would be drawn again for nothing.
        if (JSON.stringify(notes) !== JSON.stringify(this.notes)) this.notes = notes;
      },
      onChange: changed,
    });
  }

  /** Asks for more than the span, in steps, so that a small move asks for nothing new. */
  loadNotes(site: string, span: TimeSpan): void {
    const step = 2 ** Math.max(20, Math.ceil(Math.log2(lengthOf(span))));
    const fromUs = Math.max(0, Math.floor(span.fromUs / step) * step);
    const toUs = Math.ceil(span.toUs / step) * step;
    this.asker.request({ site, span: { fromUs, toUs }, edition: this.edition });
  }

  get failed(): boolean {
    return this.asker.state === "failed";
  }

  /** The next `loadNotes` asks, also for the same span. */
  invalidate(): void {
    this.edition += 1;
  }

  close(): void {
    this.asker.cancelRequest();
    this.notes = NONE;
  }
}
