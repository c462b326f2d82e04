import { describe, expect, it } from "vitest";
import { firstIndexFrom, nearestIndex } from "../../src/series/binary-search.js";
import { forSeeds, timesOf } from "./seeded.js";

describe("search", () => {
  it("finds what looking at each would find", () => {
    forSeeds(50, (roll) => {
      const times = timesOf(roll, Math.floor(roll() * 40), 0, 5);
      for (let at = -3; at < 250; at += 1) {
        const first = times.findIndex((time) => time >= at);
        expect(firstIndexFrom(times, at)).toBe(first === -1 ? times.length : first);
        const closest = Math.min(...times.map((time) => Math.abs(time - at)));
        const found = nearestIndex(times, at);
        if (times.length === 0) expect(found).toBe(-1);
        else expect(Math.abs((times[found] ?? NaN) - at)).toBe(closest);
      }
    });
  });
});
