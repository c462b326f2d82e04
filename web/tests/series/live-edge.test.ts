import { describe, expect, it } from "vitest";
import { LiveEdge } from "../../src/series/live-edge.js";

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
