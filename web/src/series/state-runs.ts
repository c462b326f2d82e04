/** States over time: stretches in which nothing changed. */

export interface StateRun {
  readonly fromUs: number;
  readonly toUs: number;
  readonly value: number;
}

/**
 * Samples of a state to stretches, from the first to `toUs`. A state holds until the next sample,
 * but for no longer than `allowedUs`: after that nobody knows.
 */
export function stateRuns(times: ArrayLike<number>, values: ArrayLike<number>, toUs: number, allowedUs: number): StateRun[] {
  const found: StateRun[] = [];
  let open: { fromUs: number; value: number } | null = null;
  let last = NaN;
  const closeRun = (untilUs: number): void => {
    if (open !== null && untilUs > open.fromUs) found.push({ ...open, toUs: untilUs });
    open = null;
  };
  for (let i = 0; i < times.length && (times[i] ?? NaN) <= toUs; i += 1) {
    const at = times[i] ?? NaN;
    // A state is a whole number; adding zero takes the sign from minus zero.
    const value = Math.round(values[i] ?? NaN) + 0;
    if (at - last > allowedUs) closeRun(last + allowedUs);
    else if (!Object.is(value, valueOf(open))) closeRun(at);
    if (open === null && !Number.isNaN(value)) open = { fromUs: at, value };
    last = at;
  }
  closeRun(Math.min(toUs, last + allowedUs));
  return found;
}

function valueOf(open: { value: number } | null): number {
  return open === null ? NaN : open.value;
}
