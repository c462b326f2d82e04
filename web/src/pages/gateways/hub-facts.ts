/** What is said of one of several hubs. */

import { formatBytes } from "../../format/bytes.js";
import { formatAge, formatDuration, formatWholeMs } from "../../format/duration.js";
import type { HubShape } from "../../generated/api.js";

/** @param nowUs UTC, by this browser's clock */
export function hubFacts(hub: HubShape, nowUs: number): readonly string[] {
  // What it said last is of the past, however well it was then.
  if (hub.role === "gone") return [`last heard ${formatAge(hub.silent_s)}`];
  const facts = [
    `version ${hub.version}`,
    `${countOf(hub.gateways, "gateway", "gateways")} and ${countOf(hub.sockets, "socket", "sockets")} came in here`,
    `${(hub.cpu * 100).toFixed(0)} % of a core`,
    formatBytes(hub.memory_bytes),
    hub.database_ms === 0 ? "no answer from the database" : `database ${formatWholeMs(hub.database_ms)}`,
  ];
  return [...facts, `up for ${formatDuration((nowUs - hub.since_us) / 1e6)}`];
}

function countOf(many: number, one: string, more: string): string {
  return `${String(many)} ${many === 1 ? one : more}`;
}
