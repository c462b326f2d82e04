/** A target of the telescope: by name or by coordinates, with what is to be said of it. Pure. */

import { msg, str } from "@lit/localize";
import { fixedText } from "../../format/number.js";
import type { SkyObject } from "../../generated/api.js";
import { parseDec, parseRa } from "../../format/sexagesimal.js";
import { moonAt, moonFrom, sunFrom } from "../../sky/sun-and-moon.js";
import { STARS } from "../../sky/bright-stars.js";
import { toHorizontal, precessedFromJ2000, separation, type Equatorial, type Horizontal, type GeoPlace } from "../../sky/coordinates.js";

export interface SkyTarget {
  readonly name: string;
  /** What it is: `Galaxy in And, magnitude 3.4`. */
  readonly about: string;
  /** Where it is, J2000; null for what moves or was given for the date. */
  readonly j2000: Equatorial | null;
  /** Where it is by the equator of a moment (ms). */
  readonly at: (ms: number) => Equatorial;
}

/** What is wrong with what was typed. */
export interface CoordinateProblem {
  readonly field: "ra" | "dec";
  readonly text: string;
}

/** A place as it was typed, or why it is none. */
export function typedTarget(ra: string, dec: string, dated: boolean): SkyTarget | CoordinateProblem {
  const place = { ra: parseRa(ra), dec: parseDec(dec) };
  if (Number.isNaN(place.ra)) return { field: "ra", text: msg("Right ascension: write 5h 34m 32s, 05:34:32, 5.5756 (hours), or 83.63° .") };
  if (Number.isNaN(place.dec)) return { field: "dec", text: msg("Declination: write \u22125° 23′ 28″, -05:23:28 or -5.39 (degrees), \u221290 to 90.") };
  const at = dated ? (): Equatorial => place : (ms: number): Equatorial => precessedFromJ2000(place, ms);
  return { name: msg("Coordinates"), about: dated ? msg("as typed, of date") : msg("as typed, J2000"), j2000: dated ? null : place, at };
}

/** Bright stars and the Moon that go by a name; stars by Bayer's letter too. */
export function ownTargets(name: string): readonly SkyTarget[] {
  const asked = plainName(name);
  if (asked === "") return [];
  const moon: readonly SkyTarget[] =
    asked === "moon" || asked === "the moon" ? [{ name: msg("Moon"), about: msg("moves by its own breadth in an hour"), j2000: null, at: moonAt }] : [];
  const stars = STARS.filter((star) => plainName(star.name).startsWith(asked) || plainName(star.bayer) === asked);
  return [
    ...moon,
    ...stars.slice(0, 4).map((star): SkyTarget => {
      const j2000 = { ra: star.raDeg / 15, dec: star.decDeg };
      const bayer = star.bayer === star.name ? "" : `${star.bayer}, `;
      return { name: star.name, about: msg(str`star, ${bayer}magnitude ${fixedText(star.magnitude, 1)}`), j2000, at: (ms) => precessedFromJ2000(j2000, ms) };
    }),
  ];
}

/** Something of the hub's catalogue. */
export function catalogueTarget(found: SkyObject): SkyTarget {
  const j2000 = { ra: found.ra_deg / 15, dec: found.dec_deg };
  const name = /^(NGC|IC)0*(\d.*)$/.exec(found.name);
  const messier = found.also.map((address) => /^M0*(\d+)$/.exec(address)?.[1]).find((address) => address !== undefined);
  const own = name === null ? found.name : `${name[1] ?? ""} ${name[2] ?? ""}`;
  const common = found.also.filter((address) => !/^M\d+$/.test(address));
  const also = [...(messier === undefined ? [] : [own]), ...common.slice(0, 2)];
  const magnitude = found.magnitude === null ? "" : msg(str`, magnitude ${fixedText(found.magnitude, 1)}`);
  const where = found.constellation === "" ? "" : msg(str` in ${found.constellation}`);
  return {
    name: messier === undefined ? own : `M ${messier}`,
    about: `${[...also, found.kind].filter(Boolean).join(", ")}${where}${magnitude}`,
    j2000,
    at: (ms) => precessedFromJ2000(j2000, ms),
  };
}

/** Where it stands; the Moon is lowered by its parallax. */
export function aimOf(target: SkyTarget, place: GeoPlace, ms: number): Horizontal {
  return target.at === moonAt ? moonFrom(place, ms) : toHorizontal(target.at(ms), place, ms);
}

export interface PointingLimits {
  /** The telescope may not point lower (°). */
  readonly horizon: number;
  /** Nor this near to the Sun (°), while that is up or in civil twilight. */
  readonly sun: number;
}

/** Why the gateway will refuse to go there now; empty when nothing is known against it. */
export function refusalOf(aim: Horizontal, place: GeoPlace, ms: number, limits: PointingLimits): string {
  if (aim.alt < limits.horizon) {
    return msg(str`It stands ${fixedText(aim.alt, 1).replace("-", "−")}° high; this telescope may not look below ${limits.horizon.toFixed(0)}°. The gateway will refuse it.`);
  }
  const sun = sunFrom(place, ms);
  const apart = separation(aim, sun);
  if (limits.sun > 0 && sun.alt > -6 && apart < limits.sun) {
    return msg(str`It is ${apart.toFixed(0)}° from the Sun; at least ${limits.sun.toFixed(0)}° are needed. The gateway will refuse it.`);
  }
  return "";
}

const GREEK = "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi omicron pi rho sigma tau upsilon phi chi psi omega".split(" ");

/** Lower case; Greek letters by their names, so that `alpha Lyr` finds α Lyr. */
function plainName(name: string): string {
  const letters = "αβγδεζηθικλμνξοπρστυφχψω";
  return name
    .trim()
    .toLowerCase()
    .replace(/\s+/g, " ")
    .replace(/[α-ω]/g, (letter) => GREEK[letters.indexOf(letter)] ?? letter);
}
