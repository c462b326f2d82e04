import { describe, expect, it } from "vitest";
import { Columns, summarize, thinned } from "../../src/series/columns.js";
import { forSeeds, timesOf, type Dice } from "./seeded.js";

function series(roll: Dice, count = 2000): { times: number[]; values: number[] } {
  const times = timesOf(roll, count);
  return { times, values: times.map(() => (roll() < 0.01 ? 100 : roll())) };
}

describe("columns", () => {
  it("lose no spike: least and greatest of all samples stand in them", () => {
    forSeeds(40, (roll) => {
      const { times, values } = series(roll);
      const columns = thinned(times, values, 1 + roll() * 1e6, Infinity);
      const seen = summarize(columns, -Infinity, Infinity);
      expect([seen.min, seen.max, seen.count]).toEqual([Math.min(...values), Math.max(...values), values.length]);
      expect(seen.mean).toBeCloseTo(values.reduce((sum, value) => sum + value, 0) / values.length, 6);
    });
  });

  it("are never more than the window has pixels, and one", () => {
    forSeeds(40, (roll) => {
      const { times, values } = series(roll);
      const pixels = 10 + Math.floor(roll() * 500);
      const span = (times.at(-1) ?? 0) - (times[0] ?? 0);
      expect(thinned(times, values, span / pixels, Infinity).length).toBeLessThanOrEqual(pixels + 1);
    });
  });

  it("come in the order of time, with the least not above the mean nor the mean above the greatest", () => {
    forSeeds(20, (roll) => {
      const { times, values } = series(roll);
      const columns = thinned(times, values, 300_000, 30_000);
      for (let i = 0; i < columns.length; i += 1) {
        expect(columns.minAt(i)).toBeLessThanOrEqual(columns.meanAt(i) + 1e-9);
        expect(columns.meanAt(i)).toBeLessThanOrEqual(columns.maxAt(i) + 1e-9);
        if (i > 0) expect(columns.timeAt(i)).toBeGreaterThan(columns.timeAt(i - 1));
      }
    });
  });

  it("do not change when the window moves on: what was drawn stays as it was", () => {
    forSeeds(20, (roll) => {
      const { times, values } = series(roll);
      const all = thinned(times, values, 100_000, Infinity);
      const moved = new Columns(100_000);
      times.forEach((time, i) => {
        moved.append(time, values[i] ?? NaN, Infinity);
        if (i % 7 === 0) moved.dropBefore(time - 5e6);
      });
      for (let back = 1; back <= moved.length; back += 1) {
        const [a, b] = [moved.length - back, all.length - back];
        expect([moved.timeAt(a), moved.minAt(a), moved.maxAt(a)]).toEqual([all.timeAt(b), all.minAt(b), all.maxAt(b)]);
      }
    });
  });

  it("break the line after a longer pause than allowed, and across what is no number", () => {
    const broken = (times: number[], values: number[]): boolean[] => {
      const columns = thinned(times, values, 10, 100);
      return Array.from({ length: columns.length }, (_, i) => columns.isBroken(i));
    };
    expect(broken([0, 100, 201, 250], [1, 1, 1, 1])).toEqual([false, false, true, false]);
    expect(broken([0, 50, 100], [1, NaN, 1])).toEqual([false, true]);
    expect(broken([0, 1, 2], [1, NaN, 1])).toEqual([false, true]);
  });

  it("put a lone sample where it was taken", () => {
    expect(thinned([1_234_567], [1], 1_000_000, 1).timeAt(0)).toBe(1_234_567);
  });

  it("sum up only what is in the window", () => {
    const columns = thinned([10, 20, 30, 40], [1, 5, 3, 9], 1, Infinity);
    expect(summarize(columns, 15, 35)).toEqual({ min: 3, max: 5, mean: 4, count: 2 });
    expect(summarize(columns, 50, 60).count).toBe(0);
  });
});
