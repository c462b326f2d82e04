/** What a reading of a signal says: a state's word, and whether its number can be true. */

import { msg, str } from "@lit/localize";

/** The word for a state's number; the number itself when the description has none for it. */
export function stateWord(states: readonly string[], value: number): string {
  if (Number.isNaN(value)) return "–";
  return states[Math.round(value)] ?? msg(str`state ${String(value)}`);
}

/** Whether a number is outside what its description calls possible: a station's error code, say. */
export function outOfRange(
  { type, minimum, maximum }: { readonly type: string; readonly minimum: number | null; readonly maximum: number | null },
  value: number,
): boolean {
  return type === "number" && ((minimum !== null && value < minimum) || (maximum !== null && value > maximum));
}
