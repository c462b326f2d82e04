/** What may be asked of the hub about missions. */

import type { MissionList, MissionReading, MissionRunList, MissionRunShape, MissionSaved, MissionShape, MissionText, RunActAsk } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";

export class MissionsApi {
  constructor(
    private readonly hub: Pick<HubApi, "request">,
    private readonly site: string,
  ) {}

  listMissions(): Promise<MissionList> {
    return this.hub.request("GET", this.url("/missions"));
  }

  listRuns(): Promise<MissionRunList> {
    return this.hub.request("GET", this.url("/mission-runs"));
  }

  /** @param id - empty for a new one */
  async saveMission(id: string, mission: MissionShape): Promise<void> {
    if (id === "") await this.hub.request<MissionSaved>("POST", this.url("/missions"), { mission });
    else await this.hub.request("PUT", this.missionUrl(id), { mission });
  }

  async removeMission(id: string): Promise<void> {
    await this.hub.request("DELETE", this.missionUrl(id));
  }

  /** @param first - the step to begin with, counted from 0 */
  startMission(id: string, first = 0): Promise<MissionRunShape> {
    return this.hub.request("POST", this.missionUrl(id, "/start"), { first });
  }

  async actOnRun(act: RunActAsk["act"]): Promise<void> {
    await this.hub.request("POST", this.url("/mission-runs/act"), { act });
  }

  writeText(id: string): Promise<MissionText> {
    return this.hub.request("GET", this.missionUrl(id, "/text"));
  }

  readText(text: string): Promise<MissionReading> {
    return this.hub.request("POST", this.url("/missions/reading"), { text });
  }

  private url(more: string): string {
    return `/api/sites/${encodeURIComponent(this.site)}${more}`;
  }

  private missionUrl(id: string, more = ""): string {
    return this.url(`/missions/${encodeURIComponent(id)}${more}`);
  }
}
