/** A target over one night: how high it stands when, and what that means in words. Pure. */

import { msg, str } from "@lit/localize";
import { sunFrom } from "./sun-and-moon.js";
import { toHorizontal, type Equatorial, type Horizontal, type GeoPlace } from "./coordinates.js";

const DAY_MS = 86_400_000;
const STEP_MS = 600_000;
/** Where the Sun is said to have set: its upper limb, with refraction (°). */
const SUNSET = -0.833;

/** From brightest to darkest; the Sun is lower than these (°). */
export const DARKNESS = [
  { id: "day", from: 90, name: msg("day") },
  { id: "civil", from: SUNSET, name: msg("civil twilight") },
  { id: "nautical", from: -6, name: msg("nautical twilight") },
  { id: "astronomical", from: -12, name: msg("astronomical twilight") },
  { id: "night", from: -18, name: msg("night") },
] as const;
export type Darkness = (typeof DARKNESS)[number]["id"];

export function darknessOf(sunAltitude: number): Darkness {
  return [...DARKNESS].reverse().find(({ from }) => sunAltitude < from)?.id ?? "day";
}

export interface NightPoint {
  readonly ms: number;
  /** Altitude of the target (°). */
  readonly alt: number;
  readonly sun: number;
}

export interface NightTrack {
  /** From the Sun's highest to the next one, about. */
  readonly from: number;
  readonly to: number;
  readonly points: readonly NightPoint[];
  /** The stretches of one darkness, in order. */
  readonly bands: readonly { readonly id: Darkness; readonly from: number; readonly to: number }[];
}

/** The local solar noon before a moment, from the longitude alone (within a quarter of an hour). */
export function noonBefore(ms: number, longitude: number): number {
  const shift = (0.5 - longitude / 360) * DAY_MS;
  return Math.floor((ms - shift) / DAY_MS) * DAY_MS + shift;
}

/** Follows a target of fixed coordinates of date from noon to noon. */
export function nightTrack(target: Equatorial, place: GeoPlace, ms: number): NightTrack {
  const from = noonBefore(ms, place.longitude);
  const to = from + DAY_MS;
  const points: NightPoint[] = [];
  for (let at = from; at <= to; at += STEP_MS) {
    points.push({ ms: at, alt: toHorizontal(target, place, at).alt, sun: sunFrom(place, at).alt });
  }
  return { from, to, points, bands: bandsOf(points) };
}

/** The stretches of one darkness among points in order. */
export function bandsOf(points: readonly { readonly ms: number; readonly sun: number }[]): NightTrack["bands"] {
  const bands: { id: Darkness; from: number; to: number }[] = [];
  for (const { ms, sun } of points) {
    const id = darknessOf(sun);
    const last = bands.at(-1);
    if (last?.id === id) last.to = ms;
    else {
      if (last !== undefined) last.to = ms;
      bands.push({ id, from: ms, to: ms });
    }
  }
  return bands;
}

export interface Visibility {
  /** Above the limit for a part of the dark hours. */
  readonly seen: boolean;
  /** Highest while the Sun is down, and when (ms); NaN on a day without a night. */
  readonly best: number;
  readonly bestMs: number;
  /** Highest at any time of the day (°). */
  readonly highest: number;
  readonly lowest: number;
  /** The dark hours above the limit begin and end (ms); NaN without any. */
  readonly fromMs: number;
  readonly toMs: number;
}

/** @param horizon - the telescope may not point lower (°) */
export function visibilityOf(night: NightTrack, horizon: number): Visibility {
  const dark = night.points.filter(({ sun }) => sun < SUNSET);
  const best = dark.reduce<NightPoint | null>((top, point) => (top === null || point.alt > top.alt ? point : top), null);
  const up = dark.filter(({ alt }) => alt >= horizon);
  const all = night.points.map(({ alt }) => alt);
  return {
    seen: up.length > 0,
    best: best?.alt ?? Number.NaN,
    bestMs: best?.ms ?? Number.NaN,
    highest: Math.max(...all),
    lowest: Math.min(...all),
    fromMs: up[0]?.ms ?? Number.NaN,
    toMs: up.at(-1)?.ms ?? Number.NaN,
  };
}

/**
 * What a person wants to know, in a sentence.
 *
 * @param clock - a time (ms) as it is written at the site
 */
export function visibilityText(
  now: Horizontal, sun: number, seen: Visibility, horizon: number, clock: (ms: number) => string,
): string {
  const limit = `${horizon.toFixed(0)}°`;
  if (seen.highest < 0) return msg("It never rises here.");
  if (seen.highest < horizon) {
    return msg(str`It never gets above ${limit} here; its highest is ${seen.highest.toFixed(0)}°.`);
  }
  const here =
    now.alt < 0
      ? msg("It is below the horizon now.")
      : now.alt < horizon
        ? msg(str`It is too low now: ${now.alt.toFixed(0)}°, of ${limit} that it needs.`)
        : sun >= SUNSET ? msg(str`It stands ${now.alt.toFixed(0)}° high now, by day.`) : msg(str`It stands ${now.alt.toFixed(0)}° high now.`);
  if (Number.isNaN(seen.best)) return msg(str`${here} The Sun does not set tonight.`);
  if (!seen.seen) return msg(str`${here} Above ${limit} it stands by day only, this night.`);
  const span = msg(str`${clock(seen.fromMs)} to ${clock(seen.toMs)}`);
  const whole = seen.lowest >= horizon ? msg("It never sets here. ") : "";
  return msg(str`${here} ${whole}In the dark above ${limit}: ${span}, highest ${seen.best.toFixed(0)}° at ${clock(seen.bestMs)}.`);
}
