/** Places in the sky as people write and read them. Pure. */

const two = (value: number): string => String(value).padStart(2, "0");

/** Hours as `05h 34m 32s`; NaN gives a dash. */
export function formatRa(hours: number): string {
  if (!Number.isFinite(hours)) return "–";
  const seconds = turned(Math.round(hours * 3600), 86_400);
  return `${two(Math.floor(seconds / 3600))}h ${two(Math.floor(seconds / 60) % 60)}m ${two(seconds % 60)}s`;
}

/** Degrees as `+41° 16′ 09″`, `−05° 23′ 28″`; NaN gives a dash. */
export function formatDec(degrees: number): string {
  if (!Number.isFinite(degrees)) return "–";
  const seconds = Math.round(Math.abs(degrees) * 3600);
  const sign = degrees < 0 && seconds > 0 ? "−" : "+";
  return `${sign}${two(Math.floor(seconds / 3600))}° ${two(Math.floor(seconds / 60) % 60)}′ ${two(seconds % 60)}″`;
}

/** An azimuth with the wind's letters: `275.2° W`. */
export function formatAzimuth(degrees: number, decimals = 1): string {
  if (!Number.isFinite(degrees)) return "–";
  return `${turned(degrees, 360).toFixed(decimals)}° ${windOf(degrees)}`;
}

const WINDS = ["N", "NE", "E", "SE", "S", "SW", "W", "NW"] as const;

export function windOf(degrees: number): string {
  return WINDS[Math.round(turned(degrees, 360) / 45) % 8] ?? "N";
}

/**
 * Right ascension in hours from `5h34m32s`, `05:34:32`, `5 34 32`, `5.5756`, or `83.63°` or `83.63d`.
 * NaN when it is none, or not 0 to 24 h.
 */
export function parseRa(text: string): number {
  const typed = plain(text);
  const inDegrees = /^(\d+(?:\.\d+)?)\s*(?:°|deg|d)$/i.exec(typed);
  if (inDegrees !== null) return within(Number(inDegrees[1]) / 15, 0, 24);
  const hours = parts(typed, /^(\d{1,2})(?:\s*h\s*|[\s:]+)(\d{1,2})(?:(?:\s*(?:m|['′])\s*|[\s:]+)(\d{1,2}(?:\.\d+)?)\s*(?:s|["″])?|\s*(?:m|['′])?)$/i);
  if (!Number.isNaN(hours)) return within(hours, 0, 24);
  return within(/^\d+(\.\d+)?\s*h?$/i.test(typed) ? Number(typed.replace(/\s*h$/i, "")) : Number.NaN, 0, 24);
}

/** Declination in degrees from `-5 23 28`, `+41°16′09″`, `41:16:09`, `-5.39`. NaN when it is none. */
export function parseDec(text: string): number {
  const typed = plain(text);
  const sign = typed.startsWith("-") ? -1 : 1;
  const size = typed.replace(/^[+-]\s*/, "");
  const angle = parts(size, /^(\d{1,2})(?:\s*[°d]\s*|[\s:]+)(\d{1,2})(?:(?:\s*(?:m|['′])\s*|[\s:]+)(\d{1,2}(?:\.\d+)?)\s*(?:s|["″])?|\s*(?:m|['′])?)$/i);
  if (!Number.isNaN(angle)) return within(sign * angle, -90, 90);
  return within(/^\d+(\.\d+)?\s*[°d]?$/.test(size) ? sign * Number(size.replace(/\s*[°d]$/, "")) : Number.NaN, -90, 90);
}

function plain(text: string): string {
  return text.trim().replace(/[−–]/g, "-").replace(",", ".").replace(/''/g, "″");
}

function parts(text: string, shape: RegExp): number {
  const found = shape.exec(text);
  if (found === null) return Number.NaN;
  const [minutes, seconds] = [Number(found[2]), Number(found[3] ?? 0)];
  return minutes >= 60 || seconds >= 60 ? Number.NaN : Number(found[1]) + minutes / 60 + seconds / 3600;
}

function within(value: number, low: number, high: number): number {
  return value >= low && value <= high ? value : Number.NaN;
}

/** The remainder that is never negative. */
export function turned(value: number, whole: number): number {
  return ((value % whole) + whole) % whole;
}
