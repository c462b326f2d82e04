/** How another hub that leaves heads here stands, in a word. */

import { msg } from "@lit/localize";
import type { WitnessedHubShape } from "../../generated/api.js";

/** It is heard each hour, also when it has nothing to say (µs). */
const SILENT_US = 3 * 3_600_000_000;

export function witnessState(
  row: Pick<WitnessedHubShape, "problem" | "heard_us">,
  nowUs: number,
): { readonly kind: "ok" | "warn" | "bad" | "unknown"; readonly word: string } {
  if (row.problem !== "") return { kind: "bad", word: msg("does not fit") };
  if (row.heard_us === 0) return { kind: "unknown", word: msg("not heard yet") };
  if (nowUs - row.heard_us > SILENT_US) return { kind: "warn", word: msg("silent") };
  return { kind: "ok", word: msg("fits") };
}
