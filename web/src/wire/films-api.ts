/** What may be asked of the hub about films of cameras. */

import type { FilmListShape } from "../generated/api.js";
import type { HubApi } from "./hub-api.js";

/** Later than any film: the answer lists none, and says how filming stands. */
const NEVER_US = 2 ** 53;

export class FilmsApi {
  constructor(private readonly hub: Pick<HubApi, "request">) {}

  /** Films that have something of a stretch of time (µs). */
  listFilms(site: string, fromUs: number, toUs: number, signal?: AbortSignal): Promise<FilmListShape> {
    const query = `from_us=${String(Math.max(0, Math.floor(fromUs)))}&to_us=${String(Math.ceil(toUs))}`;
    return this.hub.request("GET", `/api/sites/${encodeURIComponent(site)}/films?${query}`, undefined, { signal });
  }

  /** Which cameras are being filmed, and whether one may be. */
  recordingStatus(site: string): Promise<FilmListShape> {
    return this.listFilms(site, NEVER_US, NEVER_US);
  }

  /** The gateway does it; whether it did is seen in `now`. */
  async setRecording(site: string, stream: string, on: boolean): Promise<void> {
    await this.hub.request("POST", `/api/sites/${encodeURIComponent(site)}/recordings`, { on, stream });
  }
}

/** Where a film's file is. */
export function filmPath(site: string, film: string): string {
  return `/api/sites/${encodeURIComponent(site)}/films/${encodeURIComponent(film)}/file`;
}
