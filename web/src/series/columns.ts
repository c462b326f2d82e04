/**
 * Samples thinned to pixel columns: least, greatest and mean of each, so that no spike is lost.
 *
 * Columns are anchored to the epoch, not to the window: while a chart scrolls, a sample stays in
 * its column and the picture moves without shimmering; and a new sample touches the last one only.
 */
import { firstIndexFrom } from "./binary-search.js";

const SMALLEST = 128;

type ColumnRow = "first" | "last" | "min" | "max" | "sum" | "count" | "broken";
const ROWS: readonly ColumnRow[] = ["first", "last", "min", "max", "sum", "count", "broken"];

export class Columns {
  private rows = Object.fromEntries(ROWS.map((row) => [row, new Float64Array(SMALLEST)])) as Record<ColumnRow, Float64Array>;
  private start = 0;
  private end = 0;
  private bucket = NaN;
  private pause = false;

  /** @param widthUs the time one column stands for (µs) */
  constructor(readonly widthUs: number) {
    if (!(widthUs > 0)) throw new RangeError(`a column's width must be above 0 µs, not ${widthUs.toString()}`);
  }

  get length(): number {
    return this.end - this.start;
  }

  /** Time of column `i`: the middle of its samples (µs), so a lone sample stands where it was taken. */
  timeAt(i: number): number {
    return (this.valueAt("first", i) + this.valueAt("last", i)) / 2;
  }

  minAt(i: number): number {
    return this.valueAt("min", i);
  }

  maxAt(i: number): number {
    return this.valueAt("max", i);
  }

  meanAt(i: number): number {
    return this.valueAt("sum", i) / this.valueAt("count", i);
  }

  countAt(i: number): number {
    return this.valueAt("count", i);
  }

  /** Whether the line must not be drawn from column `i - 1` to column `i`. */
  isBroken(i: number): boolean {
    return this.valueAt("broken", i) !== 0;
  }

  /**
   * Take in a sample that is not older than the last.
   *
   * @param allowedUs a longer pause before this sample breaks the line (µs)
   */
  append(timeUs: number, value: number, allowedUs: number): void {
    if (!Number.isFinite(value)) {
      // The robot said "not a number": there is nothing to draw, and no line across it either.
      this.pause = true;
      return;
    }
    const rows = this.rows;
    const bucket = Math.floor(timeUs / this.widthUs);
    const tail = this.end - 1;
    const known = this.length > 0;
    const broken = known && (this.pause || timeUs - (rows.last[tail] ?? NaN) > allowedUs);
    this.pause = false;
    if (known && bucket === this.bucket && !broken) {
      rows.last[tail] = timeUs;
      rows.min[tail] = Math.min(rows.min[tail] ?? NaN, value);
      rows.max[tail] = Math.max(rows.max[tail] ?? NaN, value);
      rows.sum[tail] = (rows.sum[tail] ?? NaN) + value;
      rows.count[tail] = (rows.count[tail] ?? NaN) + 1;
      return;
    }
    this.bucket = bucket;
    this.openColumn(timeUs, value, broken);
  }

  /** Forget the columns that end before `timeUs`. */
  dropBefore(timeUs: number): void {
    this.start += firstIndexFrom(this.rows.last.subarray(this.start, this.end), timeUs);
  }

  /** First column that ends at or after `timeUs`. */
  firstFrom(timeUs: number): number {
    return firstIndexFrom(this.rows.last.subarray(this.start, this.end), timeUs);
  }

  private openColumn(timeUs: number, value: number, broken: boolean): void {
    if (this.end === this.rows.first.length) this.makeRoom();
    const at = this.end;
    this.rows.first[at] = timeUs;
    this.rows.last[at] = timeUs;
    this.rows.min[at] = value;
    this.rows.max[at] = value;
    this.rows.sum[at] = value;
    this.rows.count[at] = 1;
    this.rows.broken[at] = broken ? 1 : 0;
    this.end += 1;
  }

  private valueAt(row: ColumnRow, i: number): number {
    return this.rows[row][this.start + i] ?? NaN;
  }

  private makeRoom(): void {
    const held = this.length;
    const size = this.rows.first.length;
    const room = held * 2 > size ? size * 2 : size;
    for (const row of ROWS) {
      const old = this.rows[row];
      const next = room === size ? old : new Float64Array(room);
      next.set(old.subarray(this.start, this.end));
      this.rows[row] = next;
    }
    this.start = 0;
    this.end = held;
  }
}

/** Thin a whole series at once. */
export function thinned(
  times: ArrayLike<number>,
  values: ArrayLike<number>,
  widthUs: number,
  allowedUs: number,
): Columns {
  const columns = new Columns(widthUs);
  for (let i = 0; i < times.length; i += 1) columns.append(times[i] ?? NaN, values[i] ?? NaN, allowedUs);
  return columns;
}

/** Least, greatest and mean of the columns within a window; `count` 0 where there is none. */
export interface ColumnsSummary {
  readonly min: number;
  readonly max: number;
  readonly mean: number;
  readonly count: number;
}

/** Sum up what is seen between two times (µs), column by column. */
export function summarize(columns: Columns, fromUs: number, toUs: number): ColumnsSummary {
  let min = Infinity;
  let max = -Infinity;
  let sum = 0;
  let count = 0;
  for (let i = columns.firstFrom(fromUs); i < columns.length && columns.timeAt(i) <= toUs; i += 1) {
    min = Math.min(min, columns.minAt(i));
    max = Math.max(max, columns.maxAt(i));
    sum += columns.meanAt(i) * columns.countAt(i);
    count += columns.countAt(i);
  }
  return { min, max, mean: sum / count, count };
}
