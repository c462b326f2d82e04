import { describe, expect, it } from "vitest";
import { tickText, timeStep, timeTicks } from "../../src/series/time-ticks.js";
import { DAY_US, HOUR_US, MINUTE_US, SECOND_US, ZoneClock } from "../../src/series/zone-clock.js";
import { forSeeds } from "./seeded.js";

const utc = (text: string): number => Date.parse(`${text}Z`) * 1000;
const madrid = new ZoneClock("Europe/Madrid");
describe("a time axis", () => {
  it("has ascending marks within the window, no more than asked for, at every zoom", () => {
    forSeeds(200, (roll) => {
      const span = 10 ** (4 + roll() * 10);
      const from = utc("2026-03-01T00:00:00") + roll() * 60 * DAY_US;
      const step = timeStep(span, 6);
      const ticks = timeTicks(from, from + span, step, madrid);
      expect(ticks.length).toBeLessThanOrEqual(8);
      ticks.forEach((tick, i) => {
        expect(tick).toBeGreaterThanOrEqual(from);
        expect(tick).toBeLessThanOrEqual(from + span);
        if (i > 0) expect(tick).toBeGreaterThan(ticks[i - 1] ?? 0);
      });
    });
  });

  it("keeps its marks while the window moves over them", () => {
    const from = utc("2026-11-21T10:00:00.3");
    const first = timeTicks(from, from + 30 * SECOND_US, 5 * SECOND_US, madrid);
    const later = timeTicks(from + 2e6, from + 32 * SECOND_US, 5 * SECOND_US, madrid);
    expect(later).toEqual(expect.arrayContaining(first.slice(1)));
  });

  it("has midnight of the zone as a mark, also across the change to summer time", () => {
    const ticks = timeTicks(utc("2026-03-28T12:00"), utc("2026-03-31T12:00"), DAY_US, madrid);
    expect(ticks).toEqual([utc("2026-03-28T23:00"), utc("2026-03-29T22:00"), utc("2026-03-30T22:00")]);
  });

  it("says what is needed to read it and no more", () => {
    const at = utc("2026-11-21T10:05:09.25");
    expect(tickText(at, MINUTE_US, madrid)).toBe("11:05");
    expect(tickText(at, SECOND_US, madrid)).toBe("11:05:09");
    expect(tickText(at, 50_000, madrid)).toBe("11:05:09.250");
    expect(tickText(utc("2026-11-20T23:00"), HOUR_US, madrid)).toBe("21 Nov");
    expect(tickText(at, DAY_US, madrid)).toBe("21 Nov");
  });
});
