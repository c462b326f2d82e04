import { expect, test } from "vitest";
import { momentsBetween, nextMorning, nightSky, spansWhere } from "../../src/sky/night-sky.js";
import { moonFrom, sunFrom } from "../../src/sky/sun-and-moon.js";

const MONTSEC = { latitude: 42.0517, longitude: 0.7297 };
const NIGHT = { from: Date.parse("2026-11-23T16:00:00Z"), to: Date.parse("2026-11-24T07:30:00Z") };

test("a night's bands follow each other without a gap, from day through night to day", () => {
  const { bands } = nightSky(MONTSEC, NIGHT);
  expect(bands.map(({ id }) => id)).toEqual(["day", "civil", "nautical", "astronomical", "night", "astronomical", "nautical", "civil", "day"]);
  expect(bands[0]?.from).toBe(NIGHT.from);
  expect(bands.at(-1)?.to).toBe(NIGHT.to);
  for (const [i, band] of bands.slice(1).entries()) expect(band.from).toBe(bands[i]?.to);
  for (const { id, from, to } of bands) if (id === "night") expect(sunFrom(MONTSEC, (from + to) / 2).alt).toBeLessThan(-18);
});

test("the Moon is up where its altitude says so, and nowhere else", () => {
  const { moonUp, moonLit } = nightSky(MONTSEC, NIGHT);
  expect(moonUp.length).toBeGreaterThan(0);
  for (const ms of momentsBetween(NIGHT, 3_600_000)) {
    const { alt } = moonFrom(MONTSEC, ms);
    if (Math.abs(alt) > 2) expect(moonUp.some(({ from, to }) => ms >= from && ms <= to)).toBe(alt > 0);
  }
  // The day before the full Moon of 24 November 2026.
  expect(moonLit).toBeGreaterThan(0.98);
});

test("a stretch ends where it no longer holds, and a single last moment is none", () => {
  const holds = new Set([1, 2, 5]);
  expect(spansWhere([0, 1, 2, 3, 4, 5], (ms) => holds.has(ms))).toEqual([{ from: 1, to: 3 }]);
  expect(spansWhere([], () => true)).toEqual([]);
});

test("the next morning is when the Sun passes six degrees below the horizon on its way up", () => {
  const morning = nextMorning(MONTSEC, NIGHT.from) ?? 0;
  expect(Math.abs(sunFrom(MONTSEC, morning).alt + 6)).toBeLessThan(1);
  expect(morning).toBeGreaterThan(NIGHT.from);
  expect(nextMorning(MONTSEC, morning + 600_000)).toBeGreaterThan(morning + 80_000_000);
  // At the pole the Sun is down all the winter.
  expect(nextMorning({ latitude: 89, longitude: 0 }, NIGHT.from)).toBeNull();
});
