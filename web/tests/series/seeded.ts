/** Random numbers that are the same in every run, for tests over many cases. */

export interface Dice {
  /** From 0 up to, not including, 1. */
  (): number;
}

export function dice(seed: number): Dice {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = state;
    t = Math.imul(t ^ (t >>> 15), t | 1);
    t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** Calls `test` with so many different dice; the seed of a failing one is in its message. */
export function forSeeds(count: number, test: (roll: Dice) => void): void {
  for (let seed = 1; seed <= count; seed += 1) {
    try {
      test(dice(seed));
    } catch (error) {
      throw new Error(`with seed ${String(seed)}: ${String(error)}`, { cause: error });
    }
  }
}

/** Ascending times (µs) from `start`, with pauses up to `longest`. */
export function timesOf(roll: Dice, count: number, start = 1.7e15, longest = 50_000): number[] {
  const times: number[] = [];
  let at = start;
  for (let i = 0; i < count; i += 1) {
    at += 1 + Math.floor(roll() * longest);
    times.push(at);
  }
  return times;
}
