import { describe, expect, it } from "vitest";
import { formatBytes } from "../../../src/format/bytes.js";
import { filterSignals, FIRST_SORTING, signalUsage, sortSignals, toggleSorting, type SortKey } from "../../../src/pages/storage/signal-usage.js";
import { durationText, forecastText, keepText, warningOf } from "../../../src/pages/storage/storage-text.js";
import type { ChannelStorage, StorageUse } from "../../../src/wire/admin-types.js";

function channel(address: string, change: Partial<ChannelStorage> = {}): ChannelStorage {
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

const DAY_US = 86_400e6;
const NOW = Date.parse("2026-11-21T10:00:00Z") * 1000;
const USE: StorageUse = {
  kind: "SQLite 3.46", place: "/var/lib/talaia/talaia.db", database_bytes: 6e9, spare_bytes: 0, blocks_bytes: 5e9, free_bytes: 50e9, disk_bytes: 100e9,
  limit_bytes: 0, day_bytes: 1e9, full_us: NOW + 50 * DAY_US, by_limit: false, oldest_us: NOW - 90 * DAY_US, kept_days: null, warn: "", trouble: "", channels: [],
};

describe("what the forecast says", () => {
  it("names the day on which the disk is full, and what is oldest then", () => {
    expect(forecastText(USE, "UTC")).toContain("the disk is full on 10 Jan 2027. The oldest sample is of 23 Aug 2026 then.");
  });

  it("tells of a limit that is still to come and of one that is reached", () => {
    const limited = { ...USE, limit_bytes: 10e9, by_limit: true, kept_days: 10, full_us: NOW + 5 * DAY_US };
    expect(forecastText(limited, "UTC")).toContain("the limit of 10.0\u202fGB is reached on 26 Nov 2026");
    expect(forecastText(limited, "UTC")).toContain("About 10 days are kept");
    expect(forecastText({ ...limited, blocks_bytes: 10e9 }, "UTC")).toContain("is reached: the oldest samples go");
  });

  it("has a word for what never fills up, for what is not known and for what rests", () => {
    expect(forecastText({ ...USE, full_us: null }, "UTC")).toContain("a hundred years");
    expect(forecastText({ ...USE, full_us: null, free_bytes: null }, "UTC")).toContain("not the hub's to see");
    expect(forecastText({ ...USE, day_bytes: 0 }, "UTC")).toContain("Nothing came");
    expect(forecastText({ ...USE, blocks_bytes: 0, day_bytes: 0 }, "UTC")).toContain("known once");
  });

  it("warns on every page when there is something to do, and not before", () => {
    expect(warningOf(USE, "UTC")).toBeNull();
    expect(warningOf({ ...USE, warn: "soon" }, "UTC")).toMatchObject({ kind: "warn" });
    expect(warningOf({ ...USE, warn: "limit" }, "UTC")).toMatchObject({ kind: "info" });
    expect(warningOf({ ...USE, warn: "full", free_bytes: 4e8 }, "UTC")?.text).toContain("Only 400\u202fMB are free");
    expect(warningOf({ ...USE, trouble: "database or disk is full" }, "UTC")).toMatchObject({ kind: "bad" });
  });
});

describe("sizes", () => {
  it("have three digits at most", () => {
    const sizes: [number, string][] = [
      [0, "0 B"], [999, "999 B"], [999.6, "1.00 kB"], [1234, "1.23 kB"], [99_960, "100 kB"], [999_600, "1.00 MB"], [45.3e9, "45.3 GB"], [9.996e12, "10.0 TB"],
    ];
    for (const [bytes, text] of sizes) expect(formatBytes(bytes).replace("\u202f", " ")).toBe(text);
    expect(formatBytes(NaN)).toBe("–");
  });

  it("and lengths of time are told roughly", () => {
    expect([0.5, 3, 900].map(durationText)).toEqual(["12 hours", "3 days", "2.5 years"]);
    expect([0, 1, 30, 0.25].map(keepText)).toEqual(["for good", "1 day", "30 days", "0.25 days"]);
  });
});
