/**
 * A number with its unit: the stored one, or that which the person or the site wants to see. The hub
 * hands out the factors; what is stored, judged, exported and sent to a robot stays in the unit of
 * the description.
 */

import type { ShownUnitShape, SignalShape } from "../generated/api.js";
import { UNITS } from "../generated/units.js";
import { decimalsFor, formatNumber } from "./number.js";
import { ENGLISH, shownLanguage } from "../words/locale.js";

/** What stands between number and unit: nothing before a degree sign alone (SI brochure 5.4.3). */
export function unitGap(unit: string): string {
  return unit === "" || unit === "°" ? "" : "\u202f";
}

export function formatWithUnit(value: number, unit: string, decimals = -1): string {
  return formatNumber(value, decimalsFor(unit, decimals)) + unitGap(unit) + unit;
}

/** A unit as a screen reader should say it; in other languages than English its sign, which each reads by itself. */
export function spokenUnit(unit: string): string {
  return unit === "" || shownLanguage() !== ENGLISH ? unit : (UNITS[unit]?.name ?? unit);
}

/** What is needed of a signal to show its values. */
export type Showable = Pick<SignalShape, "unit" | "decimals" | "shown">;

/** A value as it is shown; null: in the unit in which it is stored. */
export function toShown(shown: ShownUnitShape | null, value: number): number {
  return shown === null ? value : value * shown.factor + shown.offset;
}

/** How much a difference of two values is as it is shown: without the zero of a scale. */
export function differenceToShown(shown: ShownUnitShape | null, difference: number): number {
  return shown === null ? difference : difference * shown.factor;
}

/** A stored value of one that is shown. */
export function toStored(shown: ShownUnitShape | null, value: number): number {
  return shown === null ? value : (value - shown.offset) / shown.factor;
}

/** A limit as it is shown; null where there is none. */
export function limitToShown(shown: ShownUnitShape | null, limit: number | null): number | null {
  return limit === null ? null : toShown(shown, limit);
}

/** In which unit a signal's values are shown, and with how many digits after the point. */
export function shownUnit({ unit, decimals, shown }: Showable): { readonly unit: string; readonly decimals: number } {
  return shown === null ? { unit, decimals } : { unit: shown.unit, decimals: shown.decimals };
}

/** A stored value of a signal as text. */
export function shownText(signal: Showable, value: number): string {
  const { unit, decimals } = shownUnit(signal);
  return formatWithUnit(toShown(signal.shown, value), unit, decimals);
}

/** A difference of two stored values of a signal as text. */
export function shownDifferenceText(signal: Showable, difference: number): string {
  const { unit, decimals } = shownUnit(signal);
  return formatWithUnit(differenceToShown(signal.shown, difference), unit, decimals);
}
