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

  /** Those that were taken for a request. */
  framesOfRequest(request: string): Promise<FrameList> {
    return this.hub.request("GET", archiveUrl(this.site, `requests/${encodeURIComponent(request)}/frames`));
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

/** All pictures of a proposal, as one file. */
export function proposalPicturesPath(site: string, proposal: string): string {
  return archiveUrl(site, `proposals/${encodeURIComponent(proposal)}/pictures`);
}

/** The archive as a table of the Virtual Observatory. */
export function obscorePath(site: string, format: "votable" | "csv"): string {
  return archiveUrl(site, `obscore?format=${format}`);
}
