/** What the sky does between two moments: twilights, and when the Moon is up. Pure. */

import type { GeoPlace } from "./coordinates.js";
import { bandsOf, type NightTrack } from "./night-visibility.js";
import { moonFrom, moonPhase, sunFrom } from "./sun-and-moon.js";

const STEP_MS = 300_000;
const DAY_MS = 86_400_000;
/** The Sun's altitude at which a night ends (°). */
const MORNING = -6;

export interface SkySpan {
  readonly from: number;
  readonly to: number;
}

export interface NightSky {
  readonly bands: NightTrack["bands"];
  /** While the Moon is above the horizon. */
  readonly moonUp: readonly SkySpan[];
  /** How much of it is lit half way, 0 to 1. */
  readonly moonLit: number;
}

/** @param from - and `to`: ms since 1970 */
export function nightSky(place: GeoPlace, { from, to }: SkySpan): NightSky {
  const moments = momentsBetween({ from, to }, STEP_MS);
  const bands = bandsOf(moments.map((ms) => ({ ms, sun: sunFrom(place, ms).alt })));
  const moonUp = spansWhere(moments, (ms) => moonFrom(place, ms).alt > 0);
  return { bands, moonUp, moonLit: moonPhase((from + to) / 2).lit };
}

/** When the Sun next rises above −6° (ms since 1970); null where it does not within two days. */
export function nextMorning(place: GeoPlace, ms: number): number | null {
  let before = sunFrom(place, ms).alt;
  for (const at of momentsBetween({ from: ms, to: ms + 2 * DAY_MS }, STEP_MS).slice(1)) {
    const { alt } = sunFrom(place, at);
    if (before < MORNING && alt >= MORNING) return at;
    before = alt;
  }
  return null;
}

/** Every so many ms, and the end. */
export function momentsBetween({ from, to }: SkySpan, step: number): readonly number[] {
  const many = Math.max(0, Math.ceil((to - from) / step));
  return [...Array.from({ length: many }, (_, i) => from + i * step), to];
}

/** The stretches of moments, in order, at which something holds; each ends at the first at which it does not. */
export function spansWhere(moments: readonly number[], holds: (ms: number) => boolean): readonly SkySpan[] {
  const spans: { from: number; to: number }[] = [];
  let open: { from: number; to: number } | null = null;
  for (const ms of moments) {
    if (open !== null) open.to = ms;
    const held = holds(ms);
    if (held && open === null) {
      open = { from: ms, to: ms };
      spans.push(open);
    }
    if (!held) open = null;
  }
  return spans.filter(({ from, to }) => to > from);
}
