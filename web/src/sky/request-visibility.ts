/** When a request's constraints hold in a night, why they do not otherwise, and which night is better. Pure. */

import { msg, str } from "@lit/localize";
import { fixedText } from "../format/number.js";
import { separation, toHorizontal, type Equatorial, type GeoPlace, type Horizontal } from "./coordinates.js";
import { momentsBetween, spansWhere, type SkySpan } from "./night-sky.js";
import { noonBefore } from "./night-visibility.js";
import { moonFrom, moonPhase, sunFrom } from "./sun-and-moon.js";

const DAY_MS = 86_400_000;
const STEP_MS = 300_000;
/** For the search of a better night, which needs no minutes. */
const COARSE_MS = 1_200_000;
const NIGHTS_AHEAD = 366;

/** What is looked at: a place among the stars of date, or one above the horizon. */
export type SkyPlace = { readonly at: (ms: number) => Equatorial } | { readonly fixed: Horizontal };

/** What must hold; angles in degrees. The names are those of a request's constraints. */
export interface SkyConstraints {
  readonly min_altitude: number;
  readonly max_airmass: number;
  readonly min_moon_distance: number;
  readonly max_moon_illumination: number;
  readonly max_sun_altitude: number;
}

export type SkyVeto = "window" | "sun" | "altitude" | "airmass" | "moon_distance" | "moon_illumination";

export interface RequestVisibility {
  /** While all constraints hold. */
  readonly spans: readonly SkySpan[];
  /** In all (ms). */
  readonly lasts: number;
  /** Highest while the Sun is low enough and a window is open (°), and when; NaN without such a moment. */
  readonly best: number;
  readonly bestMs: number;
  /** What forbids it most often while it is dark and a window open; null where nothing ever does. */
  readonly veto: SkyVeto | null;
}

export interface VisibilityQuestion {
  readonly target: SkyPlace;
  readonly place: GeoPlace;
  readonly constraints: SkyConstraints;
  /** When it may be observed (ms); empty: at any time. */
  readonly windows: readonly SkySpan[];
}

/** From the noon before a moment to the next one. */
export function nightAround(ms: number, place: GeoPlace): SkySpan {
  const from = noonBefore(ms, place.longitude);
  return { from, to: from + DAY_MS };
}

/** The evening by whose day a night is called, also of a moment after midnight. */
export function eveningOf({ from }: SkySpan): number {
  return from + DAY_MS / 4;
}

/** Where it stands; both its airmass and its altitude are without refraction. */
export function horizontalOf(target: SkyPlace, place: GeoPlace, ms: number): Horizontal {
  return "fixed" in target ? target.fixed : toHorizontal(target.at(ms), place, ms);
}

/** The first constraint that does not hold; null where all do. */
export function vetoAt({ target, place, constraints, windows }: VisibilityQuestion, ms: number): SkyVeto | null {
  if (windows.length > 0 && !windows.some(({ from, to }) => ms >= from && ms <= to)) return "window";
  if (sunFrom(place, ms).alt > constraints.max_sun_altitude) return "sun";
  const seen = horizontalOf(target, place, ms);
  if (seen.alt < constraints.min_altitude) return "altitude";
  if (airmassOf(seen.alt) > constraints.max_airmass) return "airmass";
  const moon = moonFrom(place, ms);
  if (moon.alt <= 0) return null;
  if (separation(seen, moon) < constraints.min_moon_distance) return "moon_distance";
  return moonPhase(ms).lit > constraints.max_moon_illumination ? "moon_illumination" : null;
}

/** The secant of the zenith distance. */
export function airmassOf(alt: number): number {
  return alt <= 0 ? Number.POSITIVE_INFINITY : 1 / Math.sin((alt * Math.PI) / 180);
}

export function requestVisibility(question: VisibilityQuestion, night: SkySpan, step = STEP_MS): RequestVisibility {
  const { target, place } = question;
  const moments = momentsBetween(night, step);
  const vetoes = new Map(moments.map((ms) => [ms, vetoAt(question, ms)]));
  const spans = spansWhere(moments, (ms) => vetoes.get(ms) === null);
  const tried = moments.filter((ms) => vetoes.get(ms) !== "window" && vetoes.get(ms) !== "sun");
  let [best, bestMs] = [Number.NaN, Number.NaN];
  for (const ms of tried) {
    const { alt } = horizontalOf(target, place, ms);
    if (!(alt <= best)) [best, bestMs] = [alt, ms];
  }
  return {
    spans,
    lasts: spans.reduce((sum, { from, to }) => sum + to - from, 0),
    best,
    bestMs,
    veto: mostFrequent((tried.length > 0 ? tried : moments).map((ms) => vetoes.get(ms) ?? null)),
  };
}

function mostFrequent(vetoes: readonly (SkyVeto | null)[]): SkyVeto | null {
  const counts = new Map<SkyVeto, number>();
  for (const veto of vetoes) if (veto !== null) counts.set(veto, (counts.get(veto) ?? 0) + 1);
  return [...counts].reduce<readonly [SkyVeto, number] | null>((top, next) => (top === null || next[1] > top[1] ? next : top), null)?.[0] ?? null;
}

export interface BetterNight {
  readonly night: SkySpan;
  readonly found: RequestVisibility;
}

/** The night of the next year in whose dark hours it may be observed longest; null when it never may. */
export function bestNight(question: VisibilityQuestion, ms: number): BetterNight | null {
  const first = nightAround(ms, question.place);
  let top: BetterNight | null = null;
  for (let day = 0; day < NIGHTS_AHEAD; day += 1) {
    const night = { from: first.from + day * DAY_MS, to: first.to + day * DAY_MS };
    if (question.windows.length > 0 && !question.windows.some(({ from, to }) => from < night.to && to > night.from)) continue;
    const found = requestVisibility(question, night, COARSE_MS);
    if (found.lasts > (top?.found.lasts ?? 0)) top = { night, found };
  }
  return top;
}

/** How times are written at the site. */
export interface TimeWords {
  /** `23:20` */
  readonly clock: (ms: number) => string;
  /** `4 December` */
  readonly date: (ms: number) => string;
  /** `5 h 30 min`, of ms. */
  readonly lasting: (ms: number) => string;
}

/** What a person wants to know of a night, in a sentence or two. */
export function requestVisibilityText(
  found: RequestVisibility, constraints: SkyConstraints, better: BetterNight | null, { clock, date, lasting }: TimeWords,
): string {
  if (found.spans.length > 0) {
    const spans = found.spans.map(({ from, to }) => msg(str`${clock(from)} to ${clock(to)}`)).join(", ");
    return msg(str`It may be observed ${spans} (${lasting(found.lasts)}); highest ${found.best.toFixed(0)}° at ${clock(found.bestMs)}.`);
  }
  const why = vetoText(found, constraints);
  if (better === null) return msg(str`${why} No other night of the next year is better.`);
  return msg(str`${why} Best on ${date(better.found.spans[0]?.from ?? better.night.from)}: ${lasting(better.found.lasts)}.`);
}

function vetoText(found: RequestVisibility, limits: SkyConstraints): string {
  const altitude = limits.min_altitude.toFixed(0);
  switch (found.veto) {
    case "window":
      return msg("No window is open in this night.");
    case "sun":
      return msg(str`The Sun does not get ${Math.abs(limits.max_sun_altitude).toFixed(0)}° below the horizon in this night while a window is open.`);
    case "altitude":
      return found.best < limits.min_altitude
        ? msg(str`Never above ${altitude}° in the dark of this night: ${found.best.toFixed(0)}° at the most.`)
        : msg(str`Above ${altitude}° only while something else forbids it.`);
    case "airmass":
      return msg(str`Its airmass is never below ${fixedText(limits.max_airmass, 1)} in the dark of this night: ${fixedText(airmassOf(found.best), 1)} at the least.`);
    case "moon_distance":
      return msg(str`The Moon is nearer than ${limits.min_moon_distance.toFixed(0)}° while it is high enough.`);
    case "moon_illumination":
      return msg(str`The Moon is up and lit more than ${(limits.max_moon_illumination * 100).toFixed(0)} % while it is high enough.`);
    case null:
      return msg("It may not be observed in this night.");
  }
}
