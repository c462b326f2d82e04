/** Numbers as people read them from across a room. */

import { UNITS } from "../generated/units.js";
import { intlLocale } from "../words/locale.js";

/** Shown where there is no value. */
export const NOTHING = "–";
const MINUS = "\u2212";
const LARGEST = 1e9;

/** Digits after the point: the signal's own, or what makes sense for its unit. */
export function decimalsFor(unit: string, decimals = -1): number {
  return decimals >= 0 ? decimals : (UNITS[unit]?.decimals ?? 2);
}

/**
 * Writes a number with a fixed count of digits after the point, so that it does not dance.
 * A number that rounds to zero has no sign.
 */
export function formatNumber(value: number, decimals: number): string {
  if (Number.isNaN(value)) return NOTHING;
  if (!Number.isFinite(value)) return value > 0 ? "∞" : `${MINUS}∞`;
  const size = Math.abs(value);
  const text = size >= LARGEST ? withMark(size.toExponential(3)) : groupedDigits(size.toFixed(Math.min(decimals, 20)));
  return value < 0 && /[1-9]/.test(text) ? MINUS + text : text;
}

// A narrow space between thousands, from five digits on.
function groupedDigits(text: string): string {
  const [whole = "", rest] = text.split(".");
  const spaced = whole.length < 5 ? whole : whole.replace(/\B(?=(\d{3})+$)/g, "\u202f");
  return rest === undefined ? spaced : `${spaced}${decimalMark()}${rest}`;
}

/** A number with a fixed count of digits after the point, for within a sentence: no groups, a plain hyphen as minus. */
export function fixedText(value: number, decimals: number): string {
  return withMark(value.toFixed(decimals));
}

/** A number with so many digits that tell something, and no zeros after them. */
export function roundText(value: number, digits: number): string {
  return withMark(String(Number(value.toPrecision(digits))));
}

function withMark(text: string): string {
  return text.replace(".", decimalMark());
}

const marks = new Map<string, string>();

/** What stands before the digits after the point: a point or a comma, as the page's language has it. */
function decimalMark(): string {
  const locale = intlLocale();
  let mark = marks.get(locale);
  if (mark === undefined) {
    mark = new Intl.NumberFormat(locale).formatToParts(1.5).find(({ type }) => type === "decimal")?.value ?? ".";
    marks.set(locale, mark);
  }
  return mark;
}

/** How many there are: groups as the page's language has them. */
export function countedText(count: number): string {
  return count.toLocaleString(intlLocale());
}
