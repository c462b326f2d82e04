/** Outliers in words. */

import { msg, str } from "@lit/localize";
import { formatNumber } from "../format/number.js";
import { plural } from "../words/plural.js";
import type { Outliers } from "./outliers.js";

/**
 * `3 outliers of 600 samples (0.5 %), outside 11.2 to 13.1 V`
 *
 * @param exact every sample of the window was looked at; otherwise what the chart holds of them, or
 *   of so many (about) an even part
 */
export function outlierText(found: Outliers, unit: string, decimals: number, exact: boolean | number): string {
  const { samples, count, low, high } = found;
  const of = exact === true ? msg("samples") : exact === false ? msg("points on the chart") : msg(str`samples spread evenly among about ${formatNumber(exact, 0)}`);
  if (Number.isNaN(low)) return exact === true ? msg("Too few samples for quartiles") : exact === false ? msg("Too few points on the chart for quartiles") : msg(str`Too few samples spread evenly among about ${formatNumber(exact, 0)} for quartiles`);
  const what = count === 0 ? msg("No outliers") : plural(count, msg("1 outlier"), msg(str`${formatNumber(count, 0)} outliers`));
  const share = count === 0 ? "" : ` (${shareText(count / samples)})`;
  const fences = count === 0 ? msg(str`all within ${formatNumber(low, decimals)} to ${formatNumber(high, decimals)}${unit === "" ? "" : `\u202f${unit}`}`) : msg(str`outside ${formatNumber(low, decimals)} to ${formatNumber(high, decimals)}${unit === "" ? "" : `\u202f${unit}`}`);
  return msg(str`${what} of ${formatNumber(samples, 0)} ${of}${share}, ${fences}`);
}

function shareText(share: number): string {
  const percent = share * 100;
  return percent < 0.1 ? msg("under 0.1\u202f%") : `${formatNumber(percent, percent < 10 ? 1 : 0)}\u202f%`;
}
