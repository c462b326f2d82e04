import { describe, expect, it } from "vitest";

import { capWords } from "../../../src/controllers/drive/drive-messages.js";

describe("Why the speed is capped", () => {
  it("says nothing while all of it is allowed", () => {
    expect(capWords(1, 40, 30)).toBe("");
  });

  it("names the interlock before the link and the picture", () => {
    expect(capWords(0.2, 400, -1, "Person in the drive path")).toBe(
      "Speed capped to 20\u202f%: Person in the drive path.",
    );
  });

  it("names the slow link, then what is wrong with the picture", () => {
    expect(capWords(0.5, 200, 30)).toBe("Speed capped to 50\u202f%: the link is slow.");
    expect(capWords(0.5, 40, -1)).toBe("Speed capped to 50\u202f%: there is no picture.");
    expect(capWords(0, 40, 1200)).toBe("No driving: the picture is old.");
    expect(capWords(0.3, 40, 30)).toBe("Speed capped to 30\u202f% by the gateway.");
  });
});
