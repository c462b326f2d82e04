/** The lines of right ascension and declination that stand over a site. Pure. */

import { precessedFromJ2000, siderealHours, toHorizontal, type Equatorial, type GeoPlace, type Horizontal } from "./coordinates.js";

/** From line to line: two hours of right ascension, and as much of declination. */
const HOURS = 2;
const DEGREES = 30;
/** From point to point of a line (°): the chart joins them by straight pieces. */
const STEP = 5;
/** What is a little below the horizon is kept, so that a line reaches down to it. */
const LOWEST = -STEP - 1;

/** Names lower than this would stand on the horizon (°). */
const LOWEST_NAME = 8;

/** One line of the grid. */
export interface SkyGridLine {
  /** As people write it: `6 h` or `+30°`. */
  readonly name: string;
  readonly points: readonly Horizontal[];
}

/** Where the name of a line stands. */
export interface SkyGridName {
  readonly name: string;
  readonly at: Horizontal;
}

export interface SkyGrid {
  readonly lines: readonly SkyGridLine[];
  readonly equator: readonly SkyGridLine[];
  readonly names: readonly SkyGridName[];
}

/** @param ms - since 1970; the coordinates are those of J2000, as requests have them */
export function skyGrid(place: GeoPlace, ms: number): SkyGrid {
  const seen = (at: Equatorial): Horizontal => toHorizontal(precessedFromJ2000(at, ms), place, ms);
  const hours = steps(0, 24 - HOURS, HOURS);
  const declinations = steps(DEGREES - 90, 90 - DEGREES, DEGREES);
  // Hour circles end at the last parallel: all of them meet in the pole, where they would hide what is there.
  const circles = hours.flatMap((ra) => pieces(hourName(ra), steps(DEGREES - 90, 90 - DEGREES, STEP).map((dec) => seen({ ra, dec }))));
  const parallel = (dec: number): readonly SkyGridLine[] => pieces(degreeName(dec), steps(0, 360, STEP).map((angle) => seen({ ra: (angle / 15) % 24, dec })));
  const culminating = siderealHours(ms, place.longitude);
  const names = [
    ...hours.map((ra) => ({ name: hourName(ra), at: seen({ ra, dec: 0 }) })),
    // Each parallel is named where it is highest; the equator has its hours.
    ...declinations.filter((dec) => dec !== 0).map((dec) => ({ name: degreeName(dec), at: seen({ ra: culminating, dec }) })),
  ];
  return {
    lines: [...circles, ...declinations.filter((dec) => dec !== 0).flatMap(parallel)],
    equator: parallel(0),
    names: names.filter(({ at }) => at.alt > LOWEST_NAME),
  };
}

/** The pieces of a line that stand above the horizon. */
function pieces(name: string, points: readonly Horizontal[]): readonly SkyGridLine[] {
  const found: Horizontal[][] = [];
  let open: Horizontal[] | null = null;
  for (const point of points) {
    if (point.alt < LOWEST) {
      open = null;
    } else if (open === null) {
      open = [point];
      found.push(open);
    } else {
      open.push(point);
    }
  }
  return found.filter((piece) => piece.length > 1).map((piece) => ({ name, points: piece }));
}

function steps(from: number, to: number, step: number): readonly number[] {
  return Array.from({ length: Math.round((to - from) / step) + 1 }, (_, i) => from + i * step);
}

function hourName(ra: number): string {
  return `${String(ra)} h`;
}

function degreeName(dec: number): string {
  return `${dec > 0 ? "+" : "−"}${String(Math.abs(dec))}°`;
}
