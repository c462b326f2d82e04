/** Chances as people read them. Pure. */

import { msg } from "@lit/localize";

/** A chance of 0 to 1 as `65 %`; what is hardly possible and what is nearly certain are said so. No part of it stands on a line of its own. */
export function formatChance(chance: number): string {
  if (!Number.isFinite(chance)) return "–";
  if (chance <= 0) return msg("none", { id: "none.chance" });
  if (chance < 0.01) return msg("below 1\u00a0%");
  return chance > 0.99 ? msg("over\u00a099\u00a0%") : `${(chance * 100).toFixed(0)}\u00a0%`;
}
