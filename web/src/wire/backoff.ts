/** When what was lost is tried again: after a while by itself, and at once where there is reason to. */

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

/** Tells what stands still that asking again makes sense: the hub is there again, or somebody has signed in. */
export class Comeback {
  private readonly waiting = new Set<() => void>();

  /** Calls `resume` each time, until what it returns is called. */
  subscribe(resume: () => void): () => void {
    this.waiting.add(resume);
    return () => this.waiting.delete(resume);
  }

  announce(): void {
    for (const resume of [...this.waiting]) resume();
  }
}

/** That of this page: sockets and questions everywhere wait for the same hub. */
export const comeback = new Comeback();
