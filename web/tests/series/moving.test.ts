import { describe, expect, it } from "vitest";
import { LiveEdge } from "../../src/series/live-edge.js";
import { DrawRate } from "../../src/series/draw-rate.js";
import { stateRuns } from "../../src/series/state-runs.js";
import { firstIndexFrom, nearestIndex } from "../../src/series/binary-search.js";
import { Trace } from "../../src/series/trace.js";
import { lengthOf, notAfter, pinched, SHORTEST_US, zoomed } from "../../src/series/time-window.js";
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

describe("the live edge", () => {
  it("follows the samples that are least late, and goes on when they stop", () => {
    const edge = new LiveEdge();
    expect(edge.isKnown).toBe(false);
    for (const [taken, now] of [[0, 1040], [100, 1110], [200, 1260]] as const) edge.observe(taken * 1000, now);
    expect(edge.nowUs(1260)).toBe(250_000);
    expect(edge.nowUs(9000)).toBe(7_990_000);
  });

  it("follows a clock that is set back within ten seconds", () => {
    const edge = new LiveEdge();
    edge.observe(100e6, 0);
    for (let now = 100; now <= 10_200; now += 100) edge.observe(now * 1000, now);
    expect(edge.nowUs(10_200)).toBe(10_200_000);
  });

  it("does not jump when a new stretch of five seconds begins with a late sample", () => {
    const edge = new LiveEdge();
    edge.observe(0, 1000);
    edge.observe(5_000_000, 6300);
    expect(edge.nowUs(6300)).toBe(5_300_000);
  });

  it("counts the age of an old sample in", () => {
    const edge = new LiveEdge();
    edge.observe(1e6, 50, 3000);
    expect(edge.nowUs(50)).toBe(4e6);
  });
});

describe("runs of a state", () => {
  it("join equal samples, and end at a change", () => {
    expect(stateRuns([0, 10, 20, 30], [1, 1, 2, 2], 35, 100)).toEqual([
      { fromUs: 0, toUs: 20, value: 1 },
      { fromUs: 20, toUs: 35, value: 2 },
    ]);
  });

  it("end when the state has been silent for too long", () => {
    expect(stateRuns([0, 100], [1, 1], 200, 20)).toEqual([
      { fromUs: 0, toUs: 20, value: 1 },
      { fromUs: 100, toUs: 120, value: 1 },
    ]);
  });

  it("leave out what is no number, and what lies beyond the end", () => {
    expect(stateRuns([0, 10, 20, 90], [1, NaN, 1, 2], 30, 50)).toEqual([
      { fromUs: 0, toUs: 10, value: 1 },
      { fromUs: 20, toUs: 30, value: 1 },
    ]);
    expect(stateRuns([], [], 30, 50)).toEqual([]);
  });
});

describe("a window", () => {
  it("keeps the moment under the pointer where it is when it zooms", () => {
    forSeeds(100, (roll) => {
      const span = { fromUs: 1.7e15, toUs: 1.7e15 + 1e6 + roll() * 1e12 };
      const about = span.fromUs + roll() * lengthOf(span);
      const next = zoomed(span, 0.2 + roll() * 4, about);
      const part = (of: typeof span): number => (about - of.fromUs) / lengthOf(of);
      expect(part(next)).toBeCloseTo(part(span), 4);
    });
  });

  it("does not get shorter than a few samples, nor end in the future", () => {
    expect(lengthOf(zoomed({ fromUs: 0, toUs: 20_000 }, 1e-6, 5))).toBe(SHORTEST_US);
    expect(notAfter({ fromUs: 50, toUs: 150 }, 100)).toEqual({ fromUs: 0, toUs: 100 });
    expect(notAfter({ fromUs: 0, toUs: 90 }, 100)).toEqual({ fromUs: 0, toUs: 90 });
  });

  it("puts two pinched moments under the two fingers", () => {
    const span = pinched(1e6, 2e6, 0.25, 0.75);
    expect(span).toEqual({ fromUs: 0.5e6, toUs: 2.5e6 });
    expect(pinched(1e6, 2e6, 0.5, 0.5)).toBeNull();
    expect(pinched(2e6, 1e6, 0.2, 0.8)).toBeNull();
  });
});

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
