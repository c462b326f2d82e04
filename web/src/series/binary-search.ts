/** Binary search in ascending times. */

/** Sorted numbers, of which only the first `length` count. */
export interface SortedTimes {
  readonly length: number;
  readonly [index: number]: number;
}

/** Index of the first time that is not before `at`; `length` when all are. */
export function firstIndexFrom(times: SortedTimes, at: number, length: number = times.length): number {
  let low = 0;
  let high = length;
  while (low < high) {
    const middle = (low + high) >>> 1;
    if ((times[middle] ?? Infinity) < at) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Index of the time nearest to `at`; -1 when there is none. Of two equally near, the earlier. */
export function nearestIndex(times: SortedTimes, at: number, length: number = times.length): number {
  if (length === 0) return -1;
  const after = firstIndexFrom(times, at, length);
  if (after === 0) return 0;
  if (after === length) return length - 1;
  const before = at - (times[after - 1] ?? -Infinity);
  return before <= (times[after] ?? Infinity) - at ? after - 1 : after;
}
