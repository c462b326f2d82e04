import { describe, expect, it } from "vitest";
import { RingBuffer } from "../../src/series/ring-buffer.js";
import { forSeeds, timesOf } from "./seeded.js";

describe("a ring of samples", () => {
  it("holds what a sorted, bounded list would hold, in whatever order samples come", () => {
    forSeeds(60, (roll) => {
      const span = 1 + Math.floor(roll() * 2e6);
      const most = 1 + Math.floor(roll() * 600);
      const ring = new RingBuffer(span, most);
      let model: [number, number][] = [];
      let at = 1.7e15;
      for (let i = 0; i < 1500; i += 1) {
        at += Math.floor(roll() * 20_000);
        const time = roll() < 0.1 ? at - Math.floor(roll() * 300_000) : at;
        const value = roll();
        const newest = model.at(-1)?.[0] ?? -Infinity;
        const full = model.length >= most && time < (model[0]?.[0] ?? -Infinity);
        ring.push(time, value);
        if (time < newest - span || full || model.some(([known]) => known === time)) continue;
        model.push([time, value]);
        model.sort((a, b) => a[0] - b[0]);
        const last = model.at(-1)?.[0] ?? 0;
        model = model.filter(([known]) => known >= last - span).slice(-most);
      }
      expect([...ring.times]).toEqual(model.map(([time]) => time));
      expect([...ring.values]).toEqual(model.map(([, value]) => value));
    });
  });

  it("says where a sample went", () => {
    const ring = new RingBuffer(1000);
    expect([ring.push(5000, 1), ring.push(5200, 2), ring.push(5100, 3)]).toEqual(["end", "end", "inside"]);
    expect([ring.push(5100, 4), ring.push(4000, 5), ring.push(NaN, 6)]).toEqual(["refused", "refused", "refused"]);
    expect([...ring.values]).toEqual([1, 3, 2]);
  });

  it("takes older samples in behind those it has, and keeps its own where both know one", () => {
    const ring = new RingBuffer(10_000);
    for (const time of [500, 600, 700]) ring.push(time, 1);
    ring.backfill([100, 300, 500, 650], [2, 2, 2, 2]);
    expect([...ring.times]).toEqual([100, 300, 500, 600, 650, 700]);
    expect([...ring.values]).toEqual([2, 2, 1, 1, 2, 1]);
  });

  it("does not grow beyond its bound while it runs for long", () => {
    forSeeds(3, (roll) => {
      const ring = new RingBuffer(1e12, 500);
      for (const time of timesOf(roll, 50_000)) ring.push(time, 0);
      expect(ring.length).toBe(500);
      expect(ring.times.buffer.byteLength).toBeLessThanOrEqual(2048 * 8);
    });
  });

  it("gives a copy that later samples do not change", () => {
    const ring = new RingBuffer(1000);
    ring.push(1, 1);
    const copy = ring.copy();
    ring.push(2, 2);
    expect([...copy.times]).toEqual([1]);
    copy.push(3, 3);
    expect([...ring.times]).toEqual([1, 2]);
  });

  it("knows no newest sample while it is empty", () => {
    const ring = new RingBuffer(1000);
    expect([ring.length, ring.newest, ring.newestUs]).toEqual([0, NaN, NaN]);
    expect(() => new RingBuffer(0)).toThrow(RangeError);
  });
});
