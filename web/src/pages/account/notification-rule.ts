/** A rule of whom to tell what, as it stands in a form. Pure. */

import { formText } from "../../format/form-values.js";
import type { NoticeRuleShape, RuleAsk, Severity } from "../../generated/api.js";

export const SEVERITIES: readonly Severity[] = ["info", "warning", "critical"];

/** What a rule says where nobody has said anything else. */
export const FIRST: Required<Omit<NoticeRuleShape, "id" | "way" | "zone">> = {
  site: "*",
  target: "",
  least: "warning",
  over: true,
  own_requests: false,
  nights: false,
  quiet_from: 0,
  quiet_to: 0,
  quiet_least: "critical",
  group_s: 10,
};

/** The rule that a form asks for. */
export function ruleFromForm(said: FormData): RuleAsk {
  const text = (name: string): string => formText(said, name);
  const from = minuteOf(text("from"));
  return {
    site: text("site"),
    way: text("way"),
    target: text("target"),
    least: severityOf(text("least")),
    over: said.has("over"),
    own_requests: said.has("own_requests"),
    nights: said.has("nights"),
    quiet_from: from ?? 0,
    quiet_to: from === null ? 0 : (minuteOf(text("to")) ?? 0),
    quiet_least: severityOf(text("quiet_least")),
    zone: text("zone"),
    group_s: Math.round(Number(text("group_s")) || 0),
  };
}

/** The quiet hours of a rule as times of the day; null when it has none. */
export function quietHours(rule: Pick<RuleAsk, "quiet_from" | "quiet_to">): { readonly from: string; readonly to: string } | null {
  const { quiet_from: from = 0, quiet_to: to = 0 } = rule;
  return from === to ? null : { from: clockText(from), to: clockText(to) };
}

function severityOf(word: string): Severity {
  return SEVERITIES.find((severity) => severity === word) ?? "warning";
}

/** Minute of the day of `HH:MM`; null when there is none. */
function minuteOf(text: string): number | null {
  const match = /^(\d\d):(\d\d)/.exec(text);
  return match === null ? null : Number(match[1]) * 60 + Number(match[2]);
}

function clockText(minute: number): string {
  return `${String(Math.floor(minute / 60)).padStart(2, "0")}:${String(minute % 60).padStart(2, "0")}`;
}
