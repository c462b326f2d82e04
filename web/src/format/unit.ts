/** A number with its unit. */

import { UNITS } from "../generated/units.js";
import { decimalsFor, formatNumber } from "./number.js";

/** What stands between number and unit: nothing before a degree sign alone (SI brochure 5.4.3). */
export function unitGap(unit: string): string {
  return unit === "" || unit === "°" ? "" : "\u202f";
}

export function formatWithUnit(value: number, unit: string, decimals = -1): string {
  return formatNumber(value, decimalsFor(unit, decimals)) + unitGap(unit) + unit;
}

/** A unit as a screen reader should say it. */
export function spokenUnit(unit: string): string {
  return unit === "" ? "" : (UNITS[unit]?.name ?? unit);
}
