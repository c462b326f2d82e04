/** A cadence: one request for each visit, so far apart, each somewhere within its window. Pure. */

import { msg } from "@lit/localize";
import { HOUR_US } from "../../../series/zone-clock.js";
import { MOST_REQUESTS, type RequestDraft } from "./draft.js";
import { FieldReader } from "./field-reader.js";
import { windowDraft } from "./fill-draft.js";

export type CadenceField = "first" | "every" | "within" | "visits";

/** As it is typed: `first` by the site's clock, the rest in hours and visits. */
export type CadenceDraft = Readonly<Record<CadenceField, string>>;

export interface ReadCadence {
  /** The window of each visit (µs, UTC); empty while anything is wrong. */
  readonly windows: readonly { readonly start_us: number; readonly end_us: number }[];
  readonly problems: ReadonlyMap<CadenceField, string>;
}

/**
 * Reads a cadence.
 *
 * @param others how many requests the group has beside this one
 */
export function readCadence(draft: CadenceDraft, momentOf: (text: string) => number, others: number): ReadCadence {
  const fields = new FieldReader<CadenceField>();
  const first = momentOf(draft.first);
  if (!(first > 0)) fields.problems.set("first", msg("Write a date and a time."));
  const every = fields.number("every", draft.every, [0.05, 8760], msg("Hours between visits"));
  const within = fields.number("within", draft.within, [0.01, 4380], msg("Hours earlier or later"));
  if (within > every / 2) fields.problems.set("within", msg("More than half of what is between visits: their windows would overlap."));
  const visits = fields.whole("visits", draft.visits, [2, MOST_REQUESTS - others], msg("Visits"));
  if (fields.problems.size > 0) return { windows: [], problems: fields.problems };
  const windows = Array.from({ length: visits }, (_, i) => {
    const middle = first + i * every * HOUR_US;
    return { start_us: Math.round(middle - within * HOUR_US), end_us: Math.round(middle + within * HOUR_US) };
  });
  return { windows, problems: fields.problems };
}

/** The request, once for each window. */
export function visitsOf(request: RequestDraft, { windows }: ReadCadence, textOf: (us: number) => string): readonly RequestDraft[] {
  return windows.map((window) => ({ ...request, windows: [windowDraft(window, textOf)] }));
}
