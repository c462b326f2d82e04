/** How grave a state or a message of a robot is. Pure. */

import { msg } from "@lit/localize";
import type { SignalShape, StateMeaning } from "../generated/api.js";

export type SeverityLevel = "" | "warn" | "bad";

const MEANING_LEVELS: Readonly<Partial<Record<StateMeaning, SeverityLevel>>> = { warning: "warn", error: "bad", unsafe: "bad" };

/** The levels that INDI's and ROS's logs put before a line; a closed list, as their senders write it. */
const LOG_LEVELS: Readonly<Record<string, SeverityLevel>> = { WARN: "warn", WARNING: "warn", ERROR: "bad", FATAL: "bad" };

/** How grave a state is, by what it means, whatever it is called; empty for nothing grave. */
export function stateLevel({ meanings }: Pick<SignalShape, "meanings">, value: number): SeverityLevel {
  const meaning = meanings[Math.round(value)];
  return meaning === undefined ? "" : (MEANING_LEVELS[meaning] ?? "");
}

/** How grave a message is that begins with its level: `[ERROR] no answer`. */
export function messageLevel(text: string): SeverityLevel {
  return LOG_LEVELS[/^\[([A-Z]+)\]/.exec(text)?.[1] ?? ""] ?? "";
}

const ALARM_SEVERITIES: Readonly<Record<string, string>> = {
  critical: msg("critical", { id: "critical.severity" }),
  warning: msg("warning", { id: "warning.severity" }),
  info: msg("info", { id: "info.severity" }),
};

/** How grave an alarm is, as people read it. */
export function severityWords(severity: string): string {
  return ALARM_SEVERITIES[severity] ?? severity;
}
