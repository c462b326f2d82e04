/** What may be asked of the hub about a site's description. */

import type {
  ChangeAnswer,
  CheckAnswer,
  DescriptionList,
  DescriptionText,
  DifferenceAnswer,
  EditAnswer,
} from "../generated/api.js";
import type { HubApi } from "./hub-api.js";

/** A JSON schema, or a part of one. */
export type Schema = Readonly<Record<string, unknown>>;

export class DescriptionsApi {
  constructor(private readonly hub: Pick<HubApi, "request">) {}

  /** @param below only versions below this number; 0 for the newest */
  listVersions(site: string, below = 0): Promise<DescriptionList> {
    return this.hub.request("GET", `${descriptionUrl(site)}${below > 0 ? `?below=${String(below)}` : ""}`);
  }

  versionText(site: string, number: number): Promise<DescriptionText> {
    return this.hub.request("GET", `${descriptionUrl(site)}/${String(number)}`);
  }

  difference(site: string, before: number, after: number): Promise<DifferenceAnswer> {
    return this.hub.request("GET", `${descriptionUrl(site)}/${String(before)}/difference?to=${String(after)}`);
  }

  /** @param against the version that it is held against; 0 for none */
  checkText(site: string, text: string, against: number, signal?: AbortSignal): Promise<CheckAnswer> {
    return this.hub.request("POST", `${descriptionUrl(site)}/check`, { text, against }, { signal });
  }

  /** The text that says `wanted` instead of what it says: comments and order stay. */
  editText(site: string, text: string, wanted: object): Promise<EditAnswer> {
    return this.hub.request("POST", `${descriptionUrl(site)}/edit`, { text, site: wanted });
  }

  sendDescription(site: string, text: string, base: string): Promise<ChangeAnswer> {
    return this.hub.request("POST", descriptionUrl(site), { text, base });
  }

  restoreVersion(site: string, number: number, base: string): Promise<ChangeAnswer> {
    return this.hub.request("POST", `${descriptionUrl(site)}/${String(number)}/restore`, { base });
  }

  schema(): Promise<Schema> {
    return this.hub.request("GET", "/api/description-schema");
  }
}

function descriptionUrl(site: string): string {
  return `/api/sites/${encodeURIComponent(site)}/descriptions`;
}
