import { readFileSync } from "node:fs";
import { expect, test } from "vitest";
import { moonFrom, moonPhase, sunFrom } from "../../src/sky/sun-and-moon.js";
import { darknessOf, nightTrack, noonBefore, visibilityOf, visibilityText } from "../../src/sky/night-visibility.js";
import { STARS } from "../../src/sky/bright-stars.js";
import { toEquatorial, toHorizontal, precessedFromJ2000, separation, siderealHours } from "../../src/sky/coordinates.js";

interface Moment {
  readonly utc: string;
  readonly sidereal_h: number;
  readonly moon_lit: number;
  readonly sun: readonly [number, number];
  readonly moon: readonly [number, number];
  readonly m31: readonly [number, number];
  readonly m31_of_date: readonly [number, number];
  readonly vega: readonly [number, number];
  readonly vega_of_date: readonly [number, number];
}

// Written by astropy; tests/model/units/test_sky_vectors.py holds them to it.
const { place, moments } = JSON.parse(
  readFileSync(new URL("../../../tests/model/units/sky_vectors.json", import.meta.url), "utf8"),
) as { place: { latitude: number; longitude: number }; moments: readonly Moment[] };
const M31 = { ra: 10.68470833 / 15, dec: 41.26875 };
const VEGA = { ra: 279.23473479 / 15, dec: 38.78368896 };
const MONTSEC = { ...place };
const at = ({ utc }: Moment): number => Date.parse(`${utc}Z`);
const place2 = ([alt, az]: readonly [number, number]): { alt: number; az: number } => ({ alt, az });

test("sidereal time agrees with astropy's within two seconds", () => {
  for (const moment of moments) {
    const ours = siderealHours(at(moment), place.longitude);
    expect(Math.abs(ours - moment.sidereal_h) * 3600).toBeLessThan(2);
  }
});

test("the Sun stands where astropy says, within a fiftieth of a degree", () => {
  for (const moment of moments) expect(separation(sunFrom(MONTSEC, at(moment)), place2(moment.sun))).toBeLessThan(0.02);
});

test("the Moon stands where astropy says, within a tenth of a degree", () => {
  for (const moment of moments) expect(separation(moonFrom(MONTSEC, at(moment)), place2(moment.moon))).toBeLessThan(0.1);
});

test("the Moon is lit as much as astropy says, within a hundredth", () => {
  for (const moment of moments) expect(Math.abs(moonPhase(at(moment)).lit - moment.moon_lit)).toBeLessThan(0.01);
});

test("a catalogue's coordinates come to those of date within half a minute of arc", () => {
  for (const moment of moments) {
    for (const [from, to] of [[M31, moment.m31_of_date], [VEGA, moment.vega_of_date]] as const) {
      const { ra, dec } = precessedFromJ2000(from, at(moment));
      expect(Math.abs(dec - to[1])).toBeLessThan(0.01);
      expect(Math.abs(ra - to[0]) * 15 * Math.cos((to[1] * Math.PI) / 180)).toBeLessThan(0.01);
    }
  }
});

test("a star stands where astropy says, within a hundredth of a degree", () => {
  for (const moment of moments) {
    const seen = toHorizontal(precessedFromJ2000(M31, at(moment)), MONTSEC, at(moment));
    expect(separation(seen, place2(moment.m31))).toBeLessThan(0.02);
  }
});

test("the way to the horizon and back ends where it began", () => {
  const ms = Date.parse("2026-11-21T22:00:00Z");
  const there = toHorizontal({ ra: 5.59, dec: -5.39 }, MONTSEC, ms);
  const back = toEquatorial(there, MONTSEC, ms);
  expect(back.ra).toBeCloseTo(5.59, 9);
  expect(back.dec).toBeCloseTo(-5.39, 9);
});

test("the Sun's altitude says how dark it is", () => {
  expect([10, -0.5, -3, -8, -15, -30].map(darknessOf)).toEqual([
    "day", "day", "civil", "nautical", "astronomical", "night",
  ]);
});

test("a night goes from noon to noon and darkens and brightens in order", () => {
  const ms = Date.parse("2026-11-21T22:00:00Z");
  const night = nightTrack(M31, MONTSEC, ms);
  expect(night.from).toBeLessThanOrEqual(ms);
  expect(night.to).toBeGreaterThan(ms);
  expect(night.bands.map(({ id }) => id)).toEqual([
    "day", "civil", "nautical", "astronomical", "night", "astronomical", "nautical", "civil", "day",
  ]);
  // Montsec, this night: astronomical dusk at 18:09 UTC and dawn at 05:17 (astroplan), in steps of ten minutes.
  const dark = night.bands.find(({ id }) => id === "night");
  expect(Math.abs((dark?.from ?? 0) - Date.parse("2026-11-21T18:09:00Z"))).toBeLessThan(12 * 60_000);
  expect(Math.abs((dark?.to ?? 0) - Date.parse("2026-11-22T05:17:00Z"))).toBeLessThan(12 * 60_000);
});

test("noon comes before any moment, and not more than a day", () => {
  for (const longitude of [-180, -70.4, 0, 0.73, 179]) {
    const ms = Date.parse("2026-11-21T00:10:00Z");
    const noon = noonBefore(ms, longitude);
    expect(ms - noon).toBeGreaterThanOrEqual(0);
    expect(ms - noon).toBeLessThan(86_400_000);
  }
});

const clock = (ms: number): string => new Date(ms).toISOString().slice(11, 16);
function said(dec: number, ra = 2, horizon = 15, iso = "2026-11-21T22:00:00Z"): string {
  const ms = Date.parse(iso);
  const target = { ra, dec };
  const night = nightTrack(target, MONTSEC, ms);
  const now = toHorizontal(target, MONTSEC, ms);
  return visibilityText(now, sunFrom(MONTSEC, ms).alt, visibilityOf(night, horizon), horizon, clock);
}

test("a target of the deep south never rises", () => {
  expect(said(-70)).toBe("It never rises here.");
});

test("a target that stays below the limit says how high it gets", () => {
  expect(said(-40)).toBe("It never gets above 15° here; its highest is 8°.");
});

test("a target near the pole never sets, and says when it is highest", () => {
  expect(said(80)).toMatch(/^It stands \d+° high now\. It never sets here\. In the dark above 15°: .* at \d\d:\d\d\.$/);
});

test("a target beside the Sun stands by day only", () => {
  expect(said(-20, 15.9, 20)).toContain("by day only");
});

test("every star has a place and a name, brightest first", () => {
  expect(STARS.length).toBeGreaterThan(150);
  for (const [i, star] of STARS.entries()) {
    expect(star.name).not.toBe("");
    expect(star.raDeg >= 0 && star.raDeg < 360 && Math.abs(star.decDeg) <= 90).toBe(true);
    expect(star.magnitude).toBeGreaterThanOrEqual(STARS[i - 1]?.magnitude ?? -2);
  }
});
