import { describe, expect, it } from "vitest";
import { exportPath } from "../../src/wire/hub-api.js";

describe("the address of an export", () => {
  it("names each channel, the window, the form, and a width only for what is drawn", () => {
    const query = { channels: ["base/pose.x", "odd/ä&c"], fromUs: 1.4, toUs: 9, format: "parquet", width: 0 } as const;
    const path = exportPath("a b", query);
    expect(path).toBe("/api/sites/a%20b/export?channel=base%2Fpose.x&channel=odd%2F%C3%A4%26c&from_us=1&to_us=9&format=parquet");
    expect(exportPath("agv", { ...query, width: 800 })).toContain("&width=800");
  });
});
