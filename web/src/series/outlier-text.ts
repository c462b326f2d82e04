/** Outliers in words. */

import { formatNumber } from "../format/number.js";
import type { Outliers } from "./outliers.js";

/**
 * `3 outliers of 600 samples (0.5 %), outside 11.2 to 13.1 V`
 *
 * @param exact every sample of the window was looked at; otherwise what the chart holds of them, or
 *   of so many (about) an even part
 */
export function outlierText(found: Outliers, unit: string, decimals: number, exact: boolean | number): string {
  const { samples, count, low, high } = found;
  const of = exact === true ? "samples" : exact === false ? "points on the chart" : `samples spread evenly among about ${formatNumber(exact, 0)}`;
  if (Number.isNaN(low)) return `Too few ${of} for quartiles`;
  const what = count === 0 ? "No outliers" : count === 1 ? "1 outlier" : `${formatNumber(count, 0)} outliers`;
  const share = count === 0 ? "" : ` (${shareText(count / samples)})`;
  const fences = `${count === 0 ? "all within" : "outside"} ${formatNumber(low, decimals)} to ${formatNumber(high, decimals)}${unit === "" ? "" : `\u202f${unit}`}`;
  return `${what} of ${formatNumber(samples, 0)} ${of}${share}, ${fences}`;
}

function shareText(share: number): string {
  const percent = share * 100;
  return percent < 0.1 ? "under 0.1\u202f%" : `${formatNumber(percent, percent < 10 ? 1 : 0)}\u202f%`;
}
