/** What may be asked of the hub about recordings of raw topics. */

import type { RecordingListShape } from "../generated/api.js";
import type { HubApi } from "./hub-api.js";

export class RecordingsApi {
  constructor(private readonly hub: Pick<HubApi, "request">) {}

  listRecordings(site: string): Promise<RecordingListShape> {
    return this.hub.request("GET", `/api/sites/${encodeURIComponent(site)}/recordings`);
  }

  /** The gateway does it; whether it did is seen in the list. */
  async setRecording(site: string, on: boolean, why: string): Promise<void> {
    await this.hub.request("POST", `/api/sites/${encodeURIComponent(site)}/recordings`, { on, why });
  }

  async removeRecording(site: string, recording: string): Promise<void> {
    await this.hub.request("DELETE", `/api/sites/${encodeURIComponent(site)}/recordings/${encodeURIComponent(recording)}`);
  }
}

/** Where a recording's file is. */
export function recordingPath(site: string, recording: string): string {
  return `/api/sites/${encodeURIComponent(site)}/recordings/${encodeURIComponent(recording)}/file`;
}
