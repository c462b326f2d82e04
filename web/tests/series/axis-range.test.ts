import { describe, expect, it } from "vitest";
import { decimalsOf, niceRange, niceStep, SteadyRange } from "../../src/series/axis-range.js";
import { forSeeds } from "./seeded.js";

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
