/** Places in the sky as people write and read them. Pure. */

import { msg } from "@lit/localize";
import { fixedText } from "./number.js";

const twoDigits = (value: number): string => String(value).padStart(2, "0");

/** Hours as `05h 34m 32s`; NaN gives a dash. */
export function formatRa(hours: number): string {
  if (!Number.isFinite(hours)) return "–";
  const seconds = wrapped(Math.round(hours * 3600), 86_400);
  return `${twoDigits(Math.floor(seconds / 3600))}h ${twoDigits(Math.floor(seconds / 60) % 60)}m ${twoDigits(seconds % 60)}s`;
}

/** Degrees as `+41° 16′ 09″`, `−05° 23′ 28″`; NaN gives a dash. */
export function formatDec(degrees: number): string {
  if (!Number.isFinite(degrees)) return "–";
  const seconds = Math.round(Math.abs(degrees) * 3600);
  const sign = degrees < 0 && seconds > 0 ? "−" : "+";
  return `${sign}${twoDigits(Math.floor(seconds / 3600))}° ${twoDigits(Math.floor(seconds / 60) % 60)}′ ${twoDigits(seconds % 60)}″`;
}

/** Hours as a field takes them, to a hundredth of a second: `05:34:32.17`. */
export function writeRa(hours: number): string {
  return withColons(wrapped(Math.round(hours * 360_000), 8_640_000), 2);
}

/** Degrees as a field takes them, to a tenth of an arc second: `-05:23:28.0`. */
export function writeDec(degrees: number): string {
  const tenths = Math.round(Math.abs(degrees) * 36_000);
  return `${degrees < 0 && tenths > 0 ? "-" : "+"}${withColons(tenths, 1)}`;
}

/** @param parts of a second, so many in it as the decimals say */
function withColons(parts: number, decimals: number): string {
  const whole = 10 ** decimals;
  const seconds = Math.floor(parts / whole);
  const fraction = String(parts % whole).padStart(decimals, "0");
  return `${twoDigits(Math.floor(seconds / 3600))}:${twoDigits(Math.floor(seconds / 60) % 60)}:${twoDigits(seconds % 60)}.${fraction}`;
}

/** An azimuth with the wind's letters: `275.2° W`. */
export function formatAzimuth(degrees: number, decimals = 1): string {
  if (!Number.isFinite(degrees)) return "–";
  return `${fixedText(wrapped(degrees, 360), decimals)}° ${windOf(degrees)}`;
}

const WINDS = [msg("N"), msg("NE"), msg("E"), msg("SE"), msg("S"), msg("SW"), msg("W"), msg("NW")] as const;

export function windOf(degrees: number): string {
  return WINDS[Math.round(wrapped(degrees, 360) / 45) % 8] ?? msg("N");
}

/**
 * Right ascension in hours from `5h34m32s`, `05:34:32`, `5 34 32`, `5.5756`, or `83.63°` or `83.63d`.
 * NaN when it is none, or not 0 to 24 h.
 */
export function parseRa(text: string): number {
  const typed = plainText(text);
  const inDegrees = /^(\d+(?:\.\d+)?)\s*(?:°|deg|d)$/i.exec(typed);
  if (inDegrees !== null) return checkedRange(Number(inDegrees[1]) / 15, 0, 24);
  const hours = partsToNumber(typed, /^(\d{1,2})(?:\s*h\s*|[\s:]+)(\d{1,2})(?:(?:\s*(?:m|['′])\s*|[\s:]+)(\d{1,2}(?:\.\d+)?)\s*(?:s|["″])?|\s*(?:m|['′])?)$/i);
  if (!Number.isNaN(hours)) return checkedRange(hours, 0, 24);
  return checkedRange(/^\d+(\.\d+)?\s*h?$/i.test(typed) ? Number(typed.replace(/\s*h$/i, "")) : Number.NaN, 0, 24);
}

/** Declination in degrees from `-5 23 28`, `+41°16′09″`, `41:16:09`, `-5.39`. NaN when it is none. */
export function parseDec(text: string): number {
  const typed = plainText(text);
  const sign = typed.startsWith("-") ? -1 : 1;
  const size = typed.replace(/^[+-]\s*/, "");
  const angle = partsToNumber(size, /^(\d{1,2})(?:\s*[°d]\s*|[\s:]+)(\d{1,2})(?:(?:\s*(?:m|['′])\s*|[\s:]+)(\d{1,2}(?:\.\d+)?)\s*(?:s|["″])?|\s*(?:m|['′])?)$/i);
  if (!Number.isNaN(angle)) return checkedRange(sign * angle, -90, 90);
  return checkedRange(/^\d+(\.\d+)?\s*[°d]?$/.test(size) ? sign * Number(size.replace(/\s*[°d]$/, "")) : Number.NaN, -90, 90);
}

function plainText(text: string): string {
  return text.trim().replace(/[−–]/g, "-").replace(",", ".").replace(/''/g, "″");
}

function partsToNumber(text: string, shape: RegExp): number {
  const found = shape.exec(text);
  if (found === null) return Number.NaN;
  const [minutes, seconds] = [Number(found[2]), Number(found[3] ?? 0)];
  return minutes >= 60 || seconds >= 60 ? Number.NaN : Number(found[1]) + minutes / 60 + seconds / 3600;
}

function checkedRange(value: number, low: number, high: number): number {
  return value >= low && value <= high ? value : Number.NaN;
}

/** The remainder that is never negative. */
export function wrapped(value: number, whole: number): number {
  return ((value % whole) + whole) % whole;
}
