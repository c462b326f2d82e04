/** What may be asked of a site's archive of pictures. */

import type { FrameDetail, FrameList, NightList } from "../generated/api.js";
import type { HubApi } from "./hub-api.js";

export const STRETCHES = ["asinh", "linear", "log"] as const;
export type Stretch = (typeof STRETCHES)[number];

const archiveUrl = (site: string, more: string): string => `/api/sites/${encodeURIComponent(site)}/${more}`;

export class ArchiveApi {
  constructor(
    private readonly hub: Pick<HubApi, "request">,
    private readonly site: string,
  ) {}

  nights(): Promise<NightList> {
    return this.hub.request("GET", archiveUrl(this.site, "nights"));
  }

  findFrames(query: string): Promise<FrameList> {
    return this.hub.request("GET", archiveUrl(this.site, `frames?${query}`));
  }

  frameDetail(id: string): Promise<FrameDetail> {
    return this.hub.request("GET", archiveUrl(this.site, `frames/${encodeURIComponent(id)}`));
  }
}

/** Where a picture's drawing is, at most `px` a side. */
export function previewPath(site: string, id: string, stretch: Stretch, px: number): string {
  return archiveUrl(site, `frames/${encodeURIComponent(id)}/preview?stretch=${stretch}&px=${String(px)}`);
}

/** Where its file is. */
export function filePath(site: string, id: string): string {
  return archiveUrl(site, `frames/${encodeURIComponent(id)}/file`);
}
