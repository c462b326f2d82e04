/** What may be asked of the hub about what cameras have seen. */

import type { ReviewDays, SightingLabels, SightingList } from "../generated/api.js";
import type { HubApi } from "./hub-api.js";

const sightingsUrl = (site: string, more = ""): string => `/api/sites/${encodeURIComponent(site)}/sightings${more}`;

export class SightingsApi {
  constructor(
    private readonly hub: Pick<HubApi, "request">,
    private readonly site: string,
  ) {}

  /** @param query what is asked for, as the hub reads it */
  findSightings(query: string): Promise<SightingList> {
    return this.hub.request("GET", sightingsUrl(this.site, `?${query}`));
  }

  /** What each camera saw on each day, and how much of it the person has not looked at. */
  async reviewDays(camera: string, label: string): Promise<ReviewDays["days"]> {
    const query = new URLSearchParams({ ...(camera === "" ? {} : { camera }), ...(label === "" ? {} : { label }) }).toString();
    return (await this.hub.request<ReviewDays>("GET", sightingsUrl(this.site, query === "" ? "/days" : `/days?${query}`))).days;
  }

  /** Marks sightings as looked at by this person, or as not. */
  async markSeen(ids: readonly string[], seen: boolean): Promise<void> {
    await this.hub.request("POST", sightingsUrl(this.site, "/seen"), { ids, seen });
  }

  async labels(): Promise<SightingLabels["labels"]> {
    return (await this.hub.request<SightingLabels>("GET", sightingsUrl(this.site, "/labels"))).labels;
  }
}

/** Where a sighting's picture is. */
export function sightingPicturePath(site: string, id: string): string {
  return sightingsUrl(site, `/${encodeURIComponent(id)}/picture`);
}
