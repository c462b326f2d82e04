/** What may be asked of the hub about notes that people write. */

import type { NoteAsk, NoteChangeAsk, NoteList, NoteShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";

const notesUrl = (site: string, more = ""): string => `/api/sites/${encodeURIComponent(site)}/notes${more}`;

export class NotesApi {
  constructor(
    private readonly hub: Pick<HubApi, "request">,
    private readonly site: string,
  ) {}

  /** @param query what is asked for, as the hub reads it */
  findNotes(query: string, signal?: AbortSignal): Promise<NoteList> {
    return this.hub.request("GET", notesUrl(this.site, `?${query}`), undefined, { signal });
  }

  addNote(note: NoteAsk): Promise<NoteShape> {
    return this.hub.request("POST", notesUrl(this.site), note);
  }

  changeNote(id: string, note: NoteChangeAsk): Promise<NoteShape> {
    return this.hub.request("PUT", notesUrl(this.site, `/${encodeURIComponent(id)}`), note);
  }

  async removeNote(id: string): Promise<void> {
    await this.hub.request("DELETE", notesUrl(this.site, `/${encodeURIComponent(id)}`));
  }
}

/** Where the notes of a span are as a file. */
export function notesExportPath(site: string, { fromUs, toUs }: { readonly fromUs: number; readonly toUs: number }): string {
  return notesUrl(site, `/export?from_us=${String(Math.round(fromUs))}&to_us=${String(Math.round(toUs))}`);
}
