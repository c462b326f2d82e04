import { describe, expect, test } from "vitest";
import { formatAge, formatDuration, formatMs, formatWholeMs } from "../../src/format/duration.js";

describe("durations", () => {
  test.each([
    [0.4, "0 s"],
    [59.9, "59 s"],
    [60, "1 min"],
    [200, "3 min 20 s"],
    [7500, "2 h 5 min"],
    [273_600, "3 d 4 h"],
    [-5, "0 s"],
    [Number.NaN, "–"],
  ])("%d seconds last %s", (seconds, text) => {
    expect(formatDuration(seconds)).toBe(text);
  });

  test.each([
    [1.9, "just now"],
    [12.7, "12 s ago"],
    [185, "3 min ago"],
    [7300, "2 h ago"],
    [200_000, "2 d ago"],
  ])("%d seconds are %s", (seconds, text) => {
    expect(formatAge(seconds)).toBe(text);
  });

  test.each([
    [8.42, "8.4\u202fms"],
    [120.4, "120\u202fms"],
    [1234, "1.2\u202fs"],
  ])("%d milliseconds are %s", (ms, text) => {
    expect(formatMs(ms)).toBe(text);
  });
});

describe("whole milliseconds", () => {
  test("milliseconds are whole, and never none", () => {
    expect([0.2, 1.4, 8.6, 120, 1200].map(formatWholeMs)).toEqual(["1\u202fms", "1\u202fms", "9\u202fms", "120\u202fms", "1.2\u202fs"]);
  });
});
