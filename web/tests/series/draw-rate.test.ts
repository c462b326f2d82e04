import { describe, expect, it } from "vitest";
import { DrawRate } from "../../src/series/draw-rate.js";

describe("the pace of drawing", () => {
  it("is 30 a second while drawing is cheap, and slower when it is dear", () => {
    const pace = new DrawRate();
    for (let i = 0; i < 200; i += 1) pace.recordRound(i * 33, 2);
    expect(pace.intervalMs).toBe(33);
    for (let i = 0; i < 200; i += 1) pace.recordRound(i * 33, 30);
    expect(pace.intervalMs).toBeCloseTo(100, 0);
    for (let i = 0; i < 200; i += 1) pace.recordRound(i * 33, 900);
    expect(pace.intervalMs).toBe(250);
  });

  it("starts at once, and then waits its interval", () => {
    const pace = new DrawRate();
    expect(pace.isDue(0)).toBe(true);
    pace.recordRound(1000, 1);
    expect([pace.isDue(1016), pace.isDue(1033)]).toEqual([false, true]);
  });
});
