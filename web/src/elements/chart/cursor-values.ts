/** What stands at the cursor, as text. */

import { decimalsFor, formatNumber, NOTHING } from "../../format/number.js";
import { formatClock, formatDate } from "../../format/time.js";
import { stateWord } from "../../format/state-label.js";
import { formatWithUnit } from "../../format/unit.js";
import { firstIndexFrom, nearestIndex } from "../../series/binary-search.js";
import { SECOND_US } from "../../series/zone-clock.js";
import type { ChartSeries, CursorValue } from "./chart-model.js";

/** At this length of a window (µs) and below, a thousandth of a second is a pixel. */
const FINE_US = 120 * SECOND_US;
const DAY_US = 86_400 * SECOND_US;

/** The moment at the cursor, as finely as the window shows it. */
export function momentText(us: number, zone: string, lengthUs: number): string {
  const clock = formatClock(us, zone);
  if (lengthUs <= FINE_US) return `${clock}.${String(Math.floor((us % SECOND_US) / 1000)).padStart(3, "0")}`;
  return lengthUs < DAY_US ? clock : `${formatDate(us, zone)}, ${clock}`;
}

/**
 * The value nearest to a moment.
 *
 * @param widthUs the time one pixel column stands for; where a column holds many values, their
 *   mean is given with the least and the greatest
 * @param withinUs nothing farther away counts
 */
export function cursorValue(series: ChartSeries, us: number, widthUs: number, withinUs: number): CursorValue {
  return series.states.length > 0 ? stateAtCursor(series, us) : numberAtCursor(series, us, widthUs, withinUs);
}

function stateAtCursor(series: ChartSeries, us: number): CursorValue {
  const { times, values, allowedUs } = series.samples;
  const at = firstIndexFrom(times, us + 1) - 1;
  const timeUs = times[at] ?? NaN;
  if (!(us - timeUs <= allowedUs)) return { series, timeUs: NaN, text: NOTHING };
  return { series, timeUs, text: stateWord(series.states, values[at] ?? NaN) };
}

function numberAtCursor(series: ChartSeries, us: number, widthUs: number, withinUs: number): CursorValue {
  const columns = series.samples.columnsAt(widthUs);
  const times = Array.from({ length: 3 }, (_, i) => {
    const at = columns.firstFrom(us) - 1 + i;
    return { at, time: at >= 0 && at < columns.length ? columns.timeAt(at) : NaN };
  }).filter(({ time }) => Math.abs(time - us) <= withinUs);
  const found = times[nearestIndex(times.map(({ time }) => time), us)];
  if (found === undefined) return { series, timeUs: NaN, text: NOTHING };
  const { unit } = series;
  const decimals = decimalsFor(unit, series.decimals);
  const [min, max] = [columns.minAt(found.at), columns.maxAt(found.at)].map((value) => formatNumber(value, decimals));
  const mean = formatWithUnit(columns.meanAt(found.at), unit, decimals);
  const text = min === max || min === undefined || max === undefined ? mean : `${mean} (${min} … ${max})`;
  return { series, timeUs: found.time, text };
}
