/** Chances as people read them. Pure. */

/** A chance of 0 to 1 as `65 %`; what is hardly possible and what is nearly certain are said so. */
export function formatChance(chance: number): string {
  if (!Number.isFinite(chance)) return "–";
  if (chance <= 0) return "none";
  if (chance < 0.01) return "below 1 %";
  return chance > 0.99 ? "over 99 %" : `${(chance * 100).toFixed(0)} %`;
}
