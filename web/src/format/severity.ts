/** How grave a state or a message of a robot is. Pure. */

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
