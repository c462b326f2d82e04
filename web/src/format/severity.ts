/** How grave a robot's own words are. Pure. */

export type SeverityLevel = "" | "warn" | "bad";

// A word that stands for the whole reading, or a level that a log line begins with.
const BEGINS = /^\W*(warn(?:ing)?|caution|error|alert|fatal|critical|fault|unsafe)\b/i;
const WARNS = /^(warn|caution)/i;

/** Level of a state's word or of a message that begins with its level; empty for nothing grave. */
export function severityOf(text: string): SeverityLevel {
  const found = BEGINS.exec(text.trim())?.[1];
  if (found === undefined) return "";
  return WARNS.test(found) ? "warn" : "bad";
}
