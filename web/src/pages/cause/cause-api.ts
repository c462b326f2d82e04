/** What the page of a cause asks of the hub, and what it says to it. */

import type { CauseShape, EventList, KnownAsk, KnownShape, LogPageShape, SightingList } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { findLogLines } from "../../boards/robot-log-api.js";

const MOST = 200;

export class CauseApi {
  constructor(
    private readonly api: Pick<HubApi, "request">,
    private readonly site: string,
  ) {}

  showCause(atUs: number): Promise<CauseShape> {
    return this.api.request("GET", this.path(`/causes?at_us=${String(atUs)}`));
  }

  /** What happened and was asked for from one moment to another. */
  listEvents(fromUs: number, toUs: number): Promise<EventList> {
    return this.api.request("GET", this.path(`/events?from_us=${String(fromUs)}&to_us=${String(toUs)}&limit=${String(MOST)}`));
  }

  listSightings(fromUs: number, toUs: number): Promise<SightingList> {
    return this.api.request("GET", this.path(`/sightings?from_us=${String(fromUs)}&to_us=${String(toUs)}&limit=20`));
  }

  /** The kept lines of the robot's log; of a whole site, so that not everybody who sees some of it may read them. */
  listLog(fromUs: number, toUs: number): Promise<LogPageShape> {
    return findLogLines(this.api, this.site, `from_us=${String(fromUs)}&to_us=${String(toUs)}&limit=${String(MOST)}`);
  }

  addKnown(asked: KnownAsk): Promise<KnownShape> {
    return this.api.request("POST", this.path("/causes/known"), asked);
  }

  endKnown(key: string): Promise<void> {
    return this.api.request("DELETE", this.path(`/causes/known/${encodeURIComponent(key)}`));
  }

  /** Says of a detector's newest anomaly that it was real (`confirmed`), or none (`forgiven`). */
  judgeNewest(verdict: "confirmed" | "forgiven", asked: { readonly address: string; readonly detector: string; readonly comment: string }): Promise<unknown> {
    return this.api.request("POST", this.path(`/anomalies/${verdict}`), asked);
  }

  private path(more: string): string {
    return `/api/sites/${encodeURIComponent(this.site)}${more}`;
  }
}
