import { describe, expect, it } from "vitest";
import { Trace } from "../../src/series/trace.js";
import { forSeeds, timesOf } from "./seeded.js";

describe("a trace", () => {
  it("draws the same columns whether samples came one by one or were thinned at once", () => {
    forSeeds(20, (roll) => {
      const trace = new Trace(1e12, 5e6);
      const again = new Trace(1e12, 5e6);
      trace.columnsAt(200_000);
      for (const time of timesOf(roll, 1000)) {
        trace.addSample(time, roll());
      }
      again.backfill(trace.times, trace.values);
      const [a, b] = [trace.columnsAt(200_000), again.columnsAt(200_000)];
      expect(a.length).toBe(b.length);
      for (let i = 0; i < a.length; i += 1) expect([a.timeAt(i), a.maxAt(i)]).toEqual([b.timeAt(i), b.maxAt(i)]);
    });
  });

  it("shows a sample that came late in its place", () => {
    const trace = new Trace(1e9, 5e6);
    trace.addSample(1e6, 1);
    trace.addSample(3e6, 3);
    trace.columnsAt(1e5);
    trace.addSample(2e6, 9);
    expect([0, 1, 2].map((i) => trace.columnsAt(1e5).maxAt(i))).toEqual([1, 9, 3]);
  });

  it("counts a change only when something changed", () => {
    const trace = new Trace(1e9, 5e6);
    trace.addSample(1e6, 1);
    trace.addSample(1e6, 2);
    expect(trace.version).toBe(1);
  });

  it("stands still as a copy", () => {
    const trace = new Trace(1e9, 5e6);
    trace.addSample(1e6, 1);
    const copy = trace.copy();
    trace.addSample(2e6, 2);
    expect([copy.length, copy.newest, copy.columnsAt(10).length]).toEqual([1, 1, 1]);
  });
});
