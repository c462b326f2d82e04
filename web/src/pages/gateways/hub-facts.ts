/** What is said of one of several hubs. */

import { msg, str } from "@lit/localize";
import { formatBytes } from "../../format/bytes.js";
import { formatAge, formatDuration, formatWholeMs } from "../../format/duration.js";
import { plural } from "../../words/plural.js";
import type { HubShape } from "../../generated/api.js";

/** @param nowUs UTC, by this browser's clock */
export function hubFacts(hub: HubShape, nowUs: number): readonly string[] {
  // What it said last is of the past, however well it was then.
  if (hub.role === "gone") return [msg(str`last heard ${formatAge(hub.silent_s)}`)];
  const led = hub.shards.length === 0 ? [] : [msg(str`leads ${hub.shards.join(", ")}`)];
  const facts = [
    ...led,
    msg(str`version ${hub.version}`),
    msg(str`${plural(hub.gateways, msg("1 gateway"), msg(str`${String(hub.gateways)} gateways`))} and ${plural(hub.sockets, msg("1 socket"), msg(str`${String(hub.sockets)} sockets`))} came in here`),
    msg(str`${(hub.cpu * 100).toFixed(0)} % of a core`),
    formatBytes(hub.memory_bytes),
    hub.database_ms === 0 ? msg("no answer from the database") : msg(str`database ${formatWholeMs(hub.database_ms)}`),
  ];
  return [...facts, msg(str`up for ${formatDuration((nowUs - hub.since_us) / 1e6)}`)];
}
