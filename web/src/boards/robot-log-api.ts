/** The kept lines of a robot's log. */

import type { LogNodeList, LogPageShape } from "../generated/api.js";
import type { HubApi } from "../wire/hub-api.js";

/** @param query what is asked for, as the hub reads it */
export function findLogLines(api: Pick<HubApi, "request">, site: string, query: string): Promise<LogPageShape> {
  return api.request("GET", `/api/sites/${encodeURIComponent(site)}/log?${query}`);
}

/** The nodes of which lines are kept. */
export function listLogNodes(api: Pick<HubApi, "request">, site: string): Promise<LogNodeList> {
  return api.request("GET", `/api/sites/${encodeURIComponent(site)}/log/nodes`);
}
