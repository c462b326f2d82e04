/** The raw topics of a site that a person may follow. */

import type { GraphShape, TopicTable } from "../generated/api.js";
import type { HubApi } from "../wire/hub-api.js";

export class TopicsApi {
  constructor(
    private readonly api: HubApi,
    private readonly site: string,
  ) {}

  listTopics(): Promise<TopicTable> {
    return this.api.request("GET", `/api/sites/${encodeURIComponent(this.site)}/topics`);
  }

  /** Which nodes the robot has now, and what they publish and hear. */
  readGraph(): Promise<GraphShape> {
    return this.api.request("GET", `/api/sites/${encodeURIComponent(this.site)}/graph`);
  }
}
