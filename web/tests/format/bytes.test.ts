import { describe, expect, it } from "vitest";
import { formatBytes } from "../../src/format/bytes.js";
import { durationText, keepText } from "../../src/pages/storage/storage-text.js";

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
