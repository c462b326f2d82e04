/** A proposal as it is typed. Pure. */

import { msg, str } from "@lit/localize";
import { formText } from "../../format/form-values.js";
import { roundText } from "../../format/number.js";
import type { ProposalAsk, Urgency } from "../../generated/api.js";

export type ProposalField = "id" | "share" | "hours" | "person" | "priority";

/** What was typed, or what is wrong with it by field. */
export function readProposal(said: FormData): { readonly asked: ProposalAsk | null; readonly problems: ReadonlyMap<ProposalField, string> } {
  const problems = new Map<ProposalField, string>();
  const number = (field: ProposalField, low: number, high: number): number => {
    const text = formText(said, field).replace(",", ".");
    const value = text === "" ? Number.NaN : Number(text);
    if (!(value >= low && value <= high)) problems.set(field, msg(str`Expected ${roundText(low, 9)} to ${roundText(high, 9)}.`));
    return value;
  };
  const id = formText(said, "id");
  if (!/^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$/.test(id)) problems.set("id", msg("Expected letters, digits, points and hyphens, without blanks."));
  const urgencies: readonly Urgency[] = [...(said.has("critical") ? (["TIME_CRITICAL"] as const) : []), ...(said.has("rapid") ? (["RAPID_RESPONSE"] as const) : [])];
  const asked: ProposalAsk = {
    id,
    title: formText(said, "title"),
    share: number("share", 0, 100) / 100,
    hours_allocated: number("hours", 0, 100_000),
    person_hours: number("person", 0, 100_000),
    max_priority: number("priority", 0.001, 1000),
    urgencies,
    active: said.has("active"),
    is_open: said.has("open"),
    needs_approval: said.has("approval"),
  };
  return { asked: problems.size > 0 ? null : asked, problems };
}
