/** The address by which a tool connects, with the place of its token. */

import type { ClientProtocolShape } from "../../generated/api.js";

/** @param origin of this page: the hub's own */
export function clientAddress(row: Pick<ClientProtocolShape, "path" | "socket">, site: string, origin: string): string {
  const base = row.socket ? origin.replace(/^http/, "ws") : origin;
  const path = row.path.replace("{site}", encodeURIComponent(site));
  return `${base}${path}${path.includes("?") ? "&" : "?"}token=TOKEN`;
}
