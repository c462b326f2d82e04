import { describe, expect, it } from "vitest";
import { IntervalWatch, pauseAllowed, gapsOf, typicalInterval } from "../../src/series/gaps.js";
import { forSeeds } from "./seeded.js";

describe("gaps", () => {
  it("begin after three usual intervals, but never before the limit of age", () => {
    expect(pauseAllowed(10_000, 5e6)).toBe(5e6);
    expect(pauseAllowed(4e6, 5e6)).toBe(12e6);
    expect(pauseAllowed(NaN, 5e6)).toBe(5e6);
  });

  it("do not make the usual interval longer: it is a median", () => {
    forSeeds(20, (roll) => {
      const times: number[] = [];
      let at = 0;
      for (let i = 0; i < 3000; i += 1) times.push((at += roll() < 0.05 ? 60e6 : 9000 + roll() * 2000));
      expect(typicalInterval(times)).toBeGreaterThan(9000);
      expect(typicalInterval(times)).toBeLessThan(11_000);
      const watch = new IntervalWatch();
      times.forEach((time) => {
        watch.addTime(time);
      });
      expect(watch.typicalUs).toBeGreaterThan(9000);
      expect(watch.typicalUs).toBeLessThan(11_000);
    });
  });

  it("are found where they are", () => {
    expect(gapsOf([0, 10, 20, 90, 100], 50)).toEqual([{ from_us: 20, to_us: 90, reason: "" }]);
    expect(gapsOf([0], 50)).toEqual([]);
  });

  it("have no usual interval to go by with fewer than two samples", () => {
    expect(typicalInterval([])).toBeNaN();
    expect(typicalInterval([1])).toBeNaN();
  });
});
