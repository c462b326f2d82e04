/** What the page of a cause says of what it was told. Pure. */

import { msg, str } from "@lit/localize";
import type { CauseShape, EventShape, KnownShape, SimilarShape } from "../../generated/api.js";

export type Verdict = "confirmed" | "forgiven";

/** The moment that an address of this page is about (µs); NaN where it says none. */
export function momentOf(search: string): number {
  const at = new URLSearchParams(search).get("at") ?? "";
  return /^\d{1,16}$/.test(at) ? Number(at) : Number.NaN;
}

/** Where the cause of something at a moment is looked for. */
export function causeQuery(atUs: number): string {
  return new URLSearchParams({ at: String(Math.round(atUs)) }).toString();
}

/** Commands and driving apart from all else that happened; the anomalies themselves are ranked above. */
export function sortEvents(events: readonly EventShape[]): { readonly commands: readonly EventShape[]; readonly others: readonly EventShape[] } {
  const asked = (kind: string): boolean => ["command", "lease", "stop", "drive", "mission", "override"].some((begin) => kind.startsWith(begin));
  const rows = events.filter(({ kind }) => !kind.startsWith("anomaly"));
  return { commands: rows.filter(({ kind }) => asked(kind)), others: rows.filter(({ kind }) => !asked(kind)) };
}

/** What people said of the last episode like this one, in words. */
export function verdictText({ verdict, comment, who }: SimilarShape): string {
  if (verdict === "") return msg("Nobody said what it was.");
  const said = { confirmed: msg(str`${who} said that it was real`), forgiven: msg(str`${who} said that it was none`), known: msg(str`${who} said that it is known`) }[verdict] ?? `${who}: ${verdict}`;
  return comment === "" ? `${said}.` : `${said}: ${comment}.`;
}

/** What can be said again at one press: of known ones it holds already. */
export function repeatable(similar: SimilarShape | null): Verdict | null {
  return similar?.verdict === "confirmed" || similar?.verdict === "forgiven" ? similar.verdict : null;
}

/** The word of a person that was said of the last one, for this one. */
export function repeatedComment({ comment }: SimilarShape, when: string): string {
  const said = msg(str`same as ${when}`);
  // What was said before of a former one goes, in whichever of the two languages somebody said it.
  const [here = ""] = msg(str`same as ${"\u0000"}`).split("\u0000");
  const begun = [here, "same as "].find((start) => start !== "" && comment.startsWith(start)) ?? "";
  const rest = begun === "" ? comment : comment.slice(begun.length).replace(/^[^:]*(:\d\d)*: /, "");
  return comment === "" ? said : `${said}: ${rest}`.slice(0, 500);
}

/** While what it holds, and whether it does now. */
export function knownText({ state_name, holds }: KnownShape): string {
  if (state_name === "") return msg("at all times");
  return holds ? msg(str`while ${state_name} (now)`) : msg(str`while ${state_name}`);
}

/** Names all that were anomalous in that minute in a choice; no address of a signal is so. */
export const ALL = "all";

/** The detectors that said so of what is chosen: one, or all that were over their bars. */
export function subjectsOf(unusual: CauseShape["unusual"], chosen: string): CauseShape["unusual"] {
  if (chosen === ALL) return unusual.filter(({ score, bar }) => score >= bar);
  return unusual.filter(({ address, detector }) => `${address}~${detector}` === chosen);
}

/** By how much a score is over its bar, as a share of what is possible; below the bar 0. */
export function excessOf({ score, bar }: CauseShape["unusual"][number]): number {
  return Math.max(0, Math.min(1, (score - bar) / Math.max(1e-9, 1 - bar)));
}
