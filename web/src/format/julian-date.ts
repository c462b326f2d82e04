/** Moments as astronomers write them: Julian dates beside dates of the calendar. Times in µs since the epoch, UTC. Pure. */

const DAY_US = 86_400e6;
/** The Julian date of 1970-01-01 00:00. */
const EPOCH_JD = 2_440_587.5;
const MJD_OFFSET = 2_400_000.5;

/**
 * A moment from `JD 2460000.5`, `2460000.5`, `MJD 59999.5`, `2026-12-04` or `2026-12-04 21:30:15` (UTC); NaN when it is none.
 * It may lie before 1970.
 */
export function parseMoment(text: string): number {
  const typed = text.trim().replace(",", ".");
  const modified = /^MJD\s*(\d{1,6}(?:\.\d*)?)$/i.exec(typed);
  if (modified !== null) return julianUs(Number(modified[1]) + MJD_OFFSET);
  const julian = /^(?:[HB]?JD\s*)?(\d{7}(?:\.\d*)?)$/i.exec(typed);
  if (julian !== null) return julianUs(Number(julian[1]));
  const calendar = /^(\d{4}-\d{2}-\d{2})(?:[T ](\d{2}:\d{2}(?::\d{2}(?:\.\d{1,6})?)?))?\s*(?:Z|UTC)?$/i.exec(typed);
  if (calendar === null) return Number.NaN;
  const [, day = "", time = "00:00"] = calendar;
  return Date.parse(`${day}T${time}Z`) * 1000;
}

/** As `parseMoment` reads it again within a millisecond: a Julian date where six decimals are enough, else a date. */
export function formatMoment(us: number): string {
  const julian = `JD ${(us / DAY_US + EPOCH_JD).toFixed(6).replace(/\.?0+$/, "")}`;
  if (Math.abs(parseMoment(julian) - us) < 1000) return julian;
  return new Date(us / 1000).toISOString().replace("T", " ").replace(/\.000Z$/, "Z").replace("Z", " UTC");
}

function julianUs(julian: number): number {
  return Math.round((julian - EPOCH_JD) * 86_400_000) * 1000;
}
