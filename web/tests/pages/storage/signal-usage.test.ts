import { describe, expect, it } from "vitest";
import { filterSignals, FIRST_SORTING, signalUsage, sortSignals, toggleSorting, type SortKey } from "../../../src/pages/storage/signal-usage.js";
import type { ChannelStorageShape } from "../../../src/generated/api.js";

function channel(address: string, change: Partial<ChannelStorageShape> = {}): ChannelStorageShape {
  return {
    site: "agv", address, name: "", described: true, samples: 10, bytes: 100, day_bytes: 1, first_us: 5, last_us: 9, keep_days: 0, ...change,
  };
}
const CHANNELS = [
  channel("base/pose.x", { name: "Position", first_us: 3 }),
  channel("base/pose.y", { name: "Position", last_us: 20 }),
  channel("base/speed", { name: "Speed", bytes: 150, keep_days: 30 }),
  channel("base/old", { described: false, bytes: 5, site: "dome" }),
];
describe("what signals take", () => {
  it("is what their channels take together", () => {
    const [pose, speed, old] = signalUsage(CHANNELS);
    expect(pose).toMatchObject({ address: "base/pose", name: "Position", channels: ["base/pose.x", "base/pose.y"], samples: 20, bytes: 200, dayBytes: 2, firstUs: 3, lastUs: 20 });
    expect(speed).toMatchObject({ name: "Speed", keepDays: 30, described: true });
    expect(old).toMatchObject({ name: "base/old", described: false, site: "dome" });
  });

  it("can be sorted by each column, and turned round", () => {
    const signals = signalUsage(CHANNELS);
    const names = (by: SortKey, down: boolean): string[] => sortSignals(signals, { by, down }).map(({ name }) => name);
    expect(names("bytes", true)).toEqual(["Position", "Speed", "base/old"]);
    expect(names("bytes", false)).toEqual(["base/old", "Speed", "Position"]);
    expect(names("name", false)).toEqual(["base/old", "Position", "Speed"]);
    // For good is longer than any number of days.
    expect(names("keep", false)[0]).toBe("Speed");
    expect(names("samples", true)[0]).toBe("Position");
    expect(toggleSorting(FIRST_SORTING, "bytes")).toEqual({ by: "bytes", down: false });
    expect(toggleSorting(FIRST_SORTING, "name")).toEqual({ by: "name", down: false });
    expect(filterSignals(signals, "DOME old").map(({ address }) => address)).toEqual(["base/old"]);
  });
});
