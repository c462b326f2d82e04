/** What a key asks of the history page while no chart has the focus. */

import { keyAction } from "../../elements/chart/chart-keys.js";
import { lengthOf, type TimeSpan } from "../../series/time-window.js";
import { SECOND_US, type ZoneClock } from "../../series/zone-clock.js";
import type { HistoryView } from "./history-query.js";

export type PageKeyAction =
  | { readonly wish: "span"; readonly span: TimeSpan }
  | { readonly wish: "shown"; readonly shown: HistoryView["shown"] }
  | { readonly wish: "back" };

/** These scroll the page, as everywhere. */
const SCROLLS: readonly string[] = ["PageUp", "PageDown"];

/**
 * Arrows pan, plus and minus zoom; Home begins the window with its day (and then with the day
 * before), End follows the time; Escape and 0 go back to the window from before. Null: not ours.
 */
export function pageKeyAction(key: string, shift: boolean, span: TimeSpan, clock: ZoneClock): PageKeyAction | null {
  if (SCROLLS.includes(key)) return null;
  if (key === "Home") {
    const start = clock.dayStart(span.fromUs);
    const fromUs = start < span.fromUs ? start : clock.dayAfter(span.fromUs, -1);
    return { wish: "span", span: { fromUs, toUs: fromUs + lengthOf(span) } };
  }
  if (key === "End") return { wish: "shown", shown: { last: Math.max(1, Math.round(lengthOf(span) / SECOND_US)) } };
  if (key === "Escape") return { wish: "back" };
  const wish = keyAction(key, shift, null, span, true);
  if (wish?.wish === "span") return wish;
  return wish?.wish === "reset" ? { wish: "back" } : null;
}

/** Somebody types, or chooses among what the same keys go through. */
export function isBusy(path: readonly EventTarget[]): boolean {
  return path.some((target) => target instanceof HTMLElement && target.matches("input, select, textarea, [role=toolbar], t-menu, dialog"));
}

/** Somebody types, or the space bar presses what has the focus: films leave the key alone. */
export function isTaken(key: string, path: readonly EventTarget[]): boolean {
  const typing = "input:not([type=checkbox], [type=radio]), select, textarea, t-menu, dialog";
  const pressing = "button, a, summary, label, input";
  return path.some((target) => target instanceof HTMLElement && (target.matches(typing) || (key === " " && target.matches(pressing))));
}
