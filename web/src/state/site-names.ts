/** Names of sites that tell them apart. Pure. */

import type { SiteSummary } from "../generated/api.js";

/** Letters without case and accents: who looks for "Pena" finds "Peña". */
export function foldedText(text: string): string {
  return text.normalize("NFD").replaceAll(/\p{M}/gu, "").toLowerCase();
}

/** The same sites; where two have one name, each says its id behind it. */
export function withUniqueNames(rows: readonly SiteSummary[]): readonly SiteSummary[] {
  const counts = new Map<string, number>();
  for (const { name } of rows) counts.set(foldedText(name), (counts.get(foldedText(name)) ?? 0) + 1);
  return rows.map((row) => ((counts.get(foldedText(row.name)) ?? 0) > 1 ? { ...row, name: `${row.name} (${row.site})` } : row));
}
