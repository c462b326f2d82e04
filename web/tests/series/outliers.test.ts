import { describe, expect, it } from "vitest";
import { outlierText } from "../../src/series/outlier-text.js";
import { OutlierMemo, outliersBeyond, outliersOf, quantile } from "../../src/series/outliers.js";

const SPAN = { fromUs: 0, toUs: 99 };
const times = Array.from({ length: 100 }, (_, i) => i);

function level(change: Record<number, number> = {}): number[] {
  return times.map((i) => change[i] ?? 12 + (i % 5) / 10);
}

describe("outliers", () => {
  it("are what lies more than 1.5 times the distance of the quartiles beyond them", () => {
    // Quartiles 12.1 and 12.3: the fences stand at 11.8 and 12.6.
    const found = outliersOf(times, level({ 10: 12.61, 50: 11.79, 70: 12.59 }), SPAN, 1.5);
    expect(found.times).toEqual([10, 50]);
    expect(found.values).toEqual([12.61, 11.79]);
    expect(found.low).toBeCloseTo(11.8);
    expect(found.high).toBeCloseTo(12.6);
    expect(found.samples).toBe(100);
  });

  it("are fewer with a greater k", () => {
    expect(outliersOf(times, level({ 10: 12.61 }), SPAN, 3).count).toBe(0);
  });

  it("are looked for in the window only, and numbers only", () => {
    const values = level({ 10: 99, 20: NaN });
    const found = outliersOf(times, values, { fromUs: 11, toUs: 99 }, 1.5);
    expect(found.count).toBe(0);
    expect(found.samples).toBe(88);
  });

  it("are not told of a handful of samples", () => {
    const found = outliersOf([1, 2, 3], [1, 1, 99], SPAN, 1.5);
    expect(found.count).toBe(0);
    expect(found.low).toBeNaN();
    expect(outlierText(found, "V", 1, true)).toBe("Too few samples for quartiles");
  });

  it("are the same answer for the same question", () => {
    const memo = new OutlierMemo();
    const samples = { times, values: level({ 10: 99 }), version: 1 };
    const first = memo.outliersOf(samples, SPAN, 1.5);
    expect(memo.outliersOf(samples, { ...SPAN }, 1.5)).toBe(first);
    expect(memo.outliersOf({ ...samples, version: 2 }, SPAN, 1.5)).not.toBe(first);
  });

  it("of fences that the hub has found are the points beyond them, and counted are all samples", () => {
    const fences = { samples: 8_640_000, count: 12, low: 11.9, high: 12.35 };
    const found = outliersBeyond(times, level({ 10: 11.8, 20: NaN }), { fromUs: 5, toUs: 20 }, fences);
    expect(found.times).toEqual([9, 10, 14, 19]);
    expect(found).toMatchObject({ samples: 8_640_000, count: 12, low: 11.9, high: 12.35 });
    expect(outlierText(found, "V", 1, true)).toContain("12 outliers of 8 640 000 samples".replaceAll(" 6", "\u202f6").replaceAll(" 0", "\u202f0"));
    expect(outlierText(found, "V", 1, 2e8)).toContain("samples spread evenly among about 200");
  });

  it("of too few samples have no fences, and there are none", () => {
    const found = outliersBeyond(times, level(), SPAN, { samples: 3, count: 0, low: null, high: null });
    expect(found.times).toEqual([]);
    expect(outlierText(found, "V", 1, true)).toBe("Too few samples for quartiles");
  });

  it("quantiles lie between neighbours by share", () => {
    expect(quantile([1, 2, 3, 4], 0.25)).toBe(1.75);
    expect(quantile([5], 0.9)).toBe(5);
  });
});

describe("outliers in words", () => {
  it("say count, share and fences, and what was looked at", () => {
    const found = outliersOf(times, level({ 10: 99 }), SPAN, 1.5);
    expect(outlierText(found, "V", 1, true)).toBe("1 outlier of 100 samples (1.0\u202f%), outside 11.8 to 12.6\u202fV");
    expect(outlierText(found, "", 1, false)).toBe("1 outlier of 100 points on the chart (1.0\u202f%), outside 11.8 to 12.6");
  });

  it("say that there are none", () => {
    expect(outlierText(outliersOf(times, level(), SPAN, 1.5), "V", 1, true)).toBe("No outliers of 100 samples, all within 11.8 to 12.6\u202fV");
  });
});
