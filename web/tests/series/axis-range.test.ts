import { describe, expect, it } from "vitest";
import { decimalsOf, niceRange, niceStep, SteadyRange } from "../../src/series/axis-range.js";
import { tickText, timeStep, timeTicks } from "../../src/series/time-ticks.js";
import { DAY_US, HOUR_US, MINUTE_US, SECOND_US, ZoneClock } from "../../src/series/zone-clock.js";
import { forSeeds } from "./seeded.js";

const utc = (text: string): number => Date.parse(`${text}Z`) * 1000;
const madrid = new ZoneClock("Europe/Madrid");

describe("a value axis", () => {
  it("holds all data, and is never empty", () => {
    forSeeds(300, (roll) => {
      const size = 10 ** (roll() * 12 - 6);
      const min = (roll() - 0.5) * size;
      const max = min + (roll() < 0.2 ? 0 : roll() * size);
      const { low, high } = niceRange(min, max);
      expect(low).toBeLessThanOrEqual(min);
      expect(high).toBeGreaterThanOrEqual(max);
      expect(high).toBeGreaterThan(low);
      expect(max - min === 0 || high - low < 4 * (max - min)).toBe(true);
    });
  });

  it("gives a line that never moves a middle place on an axis one can read", () => {
    for (const value of [0, 12.36, -273.15, 1e-6, 4e9]) {
      const { low, high } = niceRange(value, value);
      expect((high - low) / (Math.abs(value) || 1)).toBeGreaterThan(0.01);
      expect((value - low) / (high - low)).toBeGreaterThan(0.2);
      expect((value - low) / (high - low)).toBeLessThan(0.8);
    }
  });

  it("ends at the signal's limits, but shows data beyond them", () => {
    const limits = { minimum: 0, maximum: 4 };
    expect(niceRange(1, 2, limits)).toEqual({ low: 0, high: 4 });
    expect(niceRange(1, 7, limits).low).toBe(0);
    expect(niceRange(1, 7, limits).high).toBeGreaterThanOrEqual(7);
  });

  it("does not blow noise up to its whole height", () => {
    const { low, high } = niceRange(21.31, 21.32, { minimum: null, maximum: null }, 2);
    expect(high - low).toBeGreaterThanOrEqual(2);
  });

  it("shows something for no data", () => {
    expect(niceRange(Infinity, -Infinity)).toEqual({ low: 0, high: 1 });
    expect(niceRange(NaN, NaN, { minimum: 9, maximum: 13 })).toEqual({ low: 9, high: 13 });
  });

  it("stays still while the data fit, grows at once, and shrinks when it is mostly empty", () => {
    const steady = new SteadyRange();
    const first = steady.nextRange(0, 10);
    expect(steady.nextRange(1, 9)).toBe(first);
    expect(steady.nextRange(0, 50).high).toBeGreaterThanOrEqual(50);
    expect(steady.nextRange(0, 5).high).toBeLessThan(10);
  });

  it("writes as many digits as its step needs", () => {
    expect([5, 0.5, 0.25, 0.02, 1e-3].map(decimalsOf)).toEqual([0, 1, 2, 2, 3]);
  });

  it("has round steps", () => {
    expect([0.011, 0.2, 3, 51, 0].map(niceStep)).toEqual([0.02, 0.2, 5, 100, 1]);
  });
});

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

describe("a zone's clock", () => {
  it("gives back the moment that it wrote into a field, whatever the zone", () => {
    for (const zone of ["UTC", "Europe/Madrid", "Asia/Kathmandu", "America/St_Johns", "Pacific/Apia"]) {
      const clock = new ZoneClock(zone);
      forSeeds(40, (roll) => {
        const at = Math.floor(utc("2020-01-01T00:00") / 1e6 + roll() * 3e8) * 1e6;
        const again = clock.fromInput(clock.toInput(at));
        // An hour that comes twice in autumn can only mean its first coming.
        expect(again === at || again === at - HOUR_US).toBe(true);
      });
    }
  });

  it("knows where days begin, also those of 23 and 25 hours", () => {
    expect(madrid.dayStart(utc("2026-03-29T12:00"))).toBe(utc("2026-03-28T23:00"));
    expect(madrid.dayAfter(utc("2026-03-29T12:00"), 1)).toBe(utc("2026-03-29T22:00"));
    expect(madrid.dayAfter(utc("2026-10-25T12:00"), 1)).toBe(utc("2026-10-25T23:00"));
    expect(madrid.dayAfter(utc("2026-11-21T12:00"), -1)).toBe(utc("2026-11-19T23:00"));
  });

  it("takes a time that summer time skips for the one an hour later, and nonsense for none", () => {
    expect(madrid.fromInput("2026-03-29T02:30:00")).toBe(utc("2026-03-29T01:30:00"));
    expect(madrid.fromInput("")).toBeNaN();
  });
});
