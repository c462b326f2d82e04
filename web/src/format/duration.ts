/** How long, and how long ago. */

import { msg, str } from "@lit/localize";
import { fixedText } from "./number.js";

const MINUTE = 60;
const HOUR = 3600;
const DAY = 86_400;

/** Two units at most: `8 s`, `3 min 20 s`, `2 h 5 min`, `3 d 4 h`. */
export function formatDuration(seconds: number): string {
  if (!Number.isFinite(seconds)) return "–";
  const whole = Math.max(0, Math.floor(seconds));
  if (whole < MINUTE) return `${String(whole)} s`;
  if (whole < HOUR) return twoUnits(whole, MINUTE, "min", 1, "s");
  if (whole < DAY) return twoUnits(whole, HOUR, "h", MINUTE, "min");
  return twoUnits(whole, DAY, "d", HOUR, "h");
}

/** `just now`, `12 s ago`, `3 min ago`: one unit, for a text that stands beside others. */
export function formatAge(seconds: number): string {
  if (!Number.isFinite(seconds)) return "–";
  if (seconds < 2) return msg("just now");
  if (seconds < MINUTE) return msg(str`${String(Math.floor(seconds))} s ago`);
  if (seconds < HOUR) return msg(str`${String(Math.floor(seconds / MINUTE))} min ago`);
  if (seconds < DAY) return msg(str`${String(Math.floor(seconds / HOUR))} h ago`);
  return msg(str`${String(Math.floor(seconds / DAY))} d ago`);
}

/** Milliseconds with digits that make sense: `8.4 ms`, `120 ms`, `1.2 s`. */
export function formatMs(ms: number): string {
  if (!Number.isFinite(ms)) return "–";
  if (ms < 10) return `${fixedText(ms, 1)}\u202fms`;
  if (ms < 1000) return `${ms.toFixed(0)}\u202fms`;
  return `${fixedText(ms / 1000, 1)}\u202fs`;
}

/** Whole milliseconds, for a number that only shall not worry anybody: `1 ms`, `120 ms`, `1.2 s`. */
export function formatWholeMs(ms: number): string {
  return ms < 10 ? `${Math.max(1, Math.round(ms)).toFixed(0)}\u202fms` : formatMs(ms);
}

function twoUnits(seconds: number, large: number, largeName: string, small: number, smallName: string): string {
  const rest = Math.floor((seconds % large) / small);
  const head = `${String(Math.floor(seconds / large))} ${largeName}`;
  return rest === 0 ? head : `${head} ${String(rest)} ${smallName}`;
}
