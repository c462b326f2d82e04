/** How long to wait before a lost connection is tried again. */

const FIRST_MS = 250;
const LONGEST_MS = 2000;

/**
 * Doubles with each failed attempt, up to 2 s, and lies anywhere between half of that and all of
 * it, so that many pages do not come back at the same moment, and a person who waits in front of
 * one has it back soon.
 *
 * @param attempt failed attempts so far, from 0
 * @param random a number in [0, 1)
 */
export function backoffMs(attempt: number, random: number): number {
  const full = Math.min(LONGEST_MS, FIRST_MS * 2 ** Math.min(attempt, 20));
  return full / 2 + (full / 2) * random;
}
