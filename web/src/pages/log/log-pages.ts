/**
 * Pages of kept lines. A search looks through a bounded number of lines at a time: a page of the hub may be short, or
 * empty, and still have a next one, so that several of them make one page of the list. Pure but for what it asks.
 */

import type { RowsPage } from "../../controllers/infinite-rows.js";
import type { LogLineShape, LogPageShape } from "../../generated/api.js";

/** So many pages of the hub are asked for at once; then what was found is shown, and the search goes on. */
const ROUNDS = 8;

export class LogPages {
  /** Where the search goes on behind a row; behind none, under the empty text. */
  private readonly places = new Map<string, string>();

  /** @param ask asks the hub for the lines behind a place; null: for the newest */
  constructor(private readonly ask: (place: string | null) => Promise<LogPageShape>) {}

  /**
   * The rows behind the row of that id, or the newest for an empty text.
   *
   * @param empty nothing has been found so far: the search goes on where it stopped
   */
  async findRows(before: string, empty: boolean): Promise<RowsPage<LogLineShape>> {
    let place = before === "" && !empty ? null : (this.places.get(before) ?? null);
    for (let round = 1; ; round += 1) {
      const { lines, next } = await this.ask(place);
      const last = lines.at(-1)?.id ?? before;
      if (next === null) this.places.delete(last);
      // Newer rows that were asked for say nothing of where the old ones go on.
      else if (before !== "" || empty || !this.places.has(last)) this.places.set(last, next);
      if (lines.length > 0 || next === null || round === ROUNDS) return { rows: lines, more: next !== null };
      place = next;
    }
  }
}
