import { describe, expect, it } from "vitest";
import { DrawRate } from "../../src/series/draw-rate.js";

describe("the pace of drawing", () => {
  it("is 30 a second while drawing is cheap, and slower when it is dear", () => {
    const pace = new DrawRate();
    for (let i = 0; i < 20; i += 1) pace.recordRound(i * 33, 2);
    expect(pace.intervalMs(false)).toBe(33);
    for (let i = 0; i < 20; i += 1) pace.recordRound(i * 33, 30);
    expect(pace.intervalMs(false)).toBeCloseTo(100, 0);
    for (let i = 0; i < 20; i += 1) pace.recordRound(i * 33, 900);
    expect(pace.intervalMs(false)).toBe(250);
  });

  it("starts at once, and then waits its interval", () => {
    const pace = new DrawRate();
    expect(pace.isDue(0, false)).toBe(true);
    pace.recordRound(1000, 1);
    expect([pace.isDue(1016, false), pace.isDue(1033, false)]).toEqual([false, true]);
  });

  it("draws what is new with the next frame, as long as drawing keeps to its share", () => {
    const pace = new DrawRate();
    pace.recordRound(1000, 2);
    expect(pace.isDue(1016, true)).toBe(true);
    for (let i = 0; i < 9; i += 1) pace.recordRound(1000, 15);
    expect([pace.isDue(1033, true), pace.isDue(1050, true)]).toEqual([false, true]);
  });

  it("is not slowed down by rounds that another program came between", () => {
    const pace = new DrawRate();
    for (let i = 0; i < 90; i += 1) pace.recordRound(i * 50, i % 3 === 0 ? 120 : 4);
    expect(pace.intervalMs(true)).toBeCloseTo(13, 0);
  });
});
