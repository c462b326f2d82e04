import { describe, expect, it } from "vitest";
import { stateRuns } from "../../src/series/state-runs.js";

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
