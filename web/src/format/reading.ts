/** A reading of a signal as a word, where a number would say nothing. */

/** The word for a state's number; the number itself when the description has none for it. */
export function stateWord(states: readonly string[], value: number): string {
  if (Number.isNaN(value)) return "–";
  return states[Math.round(value)] ?? `state ${String(value)}`;
}
