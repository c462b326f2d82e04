import { describe, expect, it } from "vitest";
import { forecastText, warningOf } from "../../../src/pages/storage/storage-text.js";
import type { StorageShape } from "../../../src/generated/api.js";

const DAY_US = 86_400e6;
const NOW = Date.parse("2026-11-21T10:00:00Z") * 1000;
const USE: StorageShape = {
  kind: "SQLite 3.46", place: "/var/lib/talaia/talaia.db", database_bytes: 6e9, spare_bytes: 0, blocks_bytes: 5e9, free_bytes: 50e9, disk_bytes: 100e9,
  limit_bytes: 0, day_bytes: 1e9, full_us: NOW + 50 * DAY_US, by_limit: false, oldest_us: NOW - 90 * DAY_US, kept_days: null, warn: "", trouble: "", files_trouble: "", channels: [],
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
    expect(warningOf({ ...USE, files_trouble: "the store of files cannot be reached" }, "UTC")).toMatchObject({
      kind: "bad", text: expect.stringContaining("the store of files cannot be reached. Gateways keep theirs") as string,
    });
    expect(warningOf({ ...USE, trouble: "database or disk is full" }, "UTC")).toMatchObject({ kind: "bad" });
  });
});
