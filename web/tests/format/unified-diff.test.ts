import { describe, expect, it } from "vitest";
import { differenceLines, differenceText } from "../../src/format/unified-diff.js";

describe("a difference in lines", () => {
  const lines = differenceLines(["@@ -3,2 +3,3 @@", " same", "-old", "+new", "+more"]);

  it("has signs beside colours, and numbers", () => {
    expect(lines.map((line) => [line.kind, line.sign, line.before, line.after])).toEqual([
      ["place", "…", 0, 0],
      ["same", " ", 3, 3],
      ["removed", "−", 4, 0],
      ["added", "+", 0, 4],
      ["added", "+", 0, 5],
    ]);
  });

  it("is said in words", () => {
    expect(differenceText(lines)).toBe("2 lines added, 1 line removed");
    expect(differenceText([])).toBe("no line differs");
  });
});
