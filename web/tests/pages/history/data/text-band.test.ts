import { describe, expect, it } from "vitest";
import { loadedSeries } from "../../../../src/pages/history/data/history-loader.js";
import { textBand } from "../../../../src/pages/history/data/text-band.js";
import { stateRuns } from "../../../../src/series/state-runs.js";

describe("what was loaded", () => {
  it("lists texts with their times", () => {
    const loaded = loadedSeries({ address: "a", t_us: [1, 2], v: [null, null], text: ["docked", "gone"], kind: "exact", gaps: [] }, 5e6);
    expect(loaded.texts).toEqual([{ timeUs: 1, text: "docked" }, { timeUs: 2, text: "gone" }]);
  });

  it("holds each text until the next, and none across a gap", () => {
    const texts = ["docked", "gone", "docked"];
    const gaps = [{ from_us: 4e6, to_us: 6e6, reason: "the spool was full" }];
    const loaded = loadedSeries({ address: "a", t_us: [1e6, 3e6, 7e6], v: [null, null, null], text: texts, kind: "exact", gaps }, 5e6);
    const { words, samples } = textBand(loaded, 5e6);
    expect(words).toEqual(["docked", "gone"]);
    expect(stateRuns(samples.times, samples.values, 8e6, samples.allowedUs)).toEqual([
      { fromUs: 1e6, toUs: 3e6, value: 0 },
      { fromUs: 3e6, toUs: 4e6 + 1, value: 1 },
      { fromUs: 7e6, toUs: 8e6, value: 0 },
    ]);
  });

  it("tells a silence once: with its reason where the hub has one", () => {
    const loaded = loadedSeries(
      {
        address: "a", t_us: [0, 1e6, 30e6, 31e6, 32e6, 33e6, 90e6], v: [1, 1, 1, 1, 1, 1, 1], kind: "exact",
        gaps: [{ from_us: 1e6, to_us: 30e6, reason: "the spool was full" }],
      },
      5e6,
    );
    expect(loaded.gaps).toEqual([
      { from_us: 1e6, to_us: 30e6, reason: "the spool was full" },
      { from_us: 33e6, to_us: 90e6, reason: "" },
    ]);
  });
});
