import { describe, expect, it } from "vitest";
import { hubFacts } from "../../../src/pages/gateways/hub-facts.js";
import type { HubShape } from "../../../src/generated/api.js";

const NOW_US = 1_780_000_000_000_000;
const HUB: HubShape = {
  name: "east", role: "leads", version: "1.2.3", own: true, since_us: NOW_US - 90e6, cpu: 0.614, memory_bytes: 190e6,
  database_ms: 1.2, gateways: 1, sockets: 12, silent_s: 0, shards: [],
};

describe("what is said of a hub", () => {
  it("is how it stands and what came in there", () => {
    expect(hubFacts(HUB, NOW_US)).toEqual([
      "version 1.2.3", "1 gateway and 12 sockets came in here", "61 % of a core", "190\u202fMB", "database 1\u202fms", "up for 1 min 30 s",
    ]);
  });

  it("is which shards it leads, where sites are divided", () => {
    expect(hubFacts({ ...HUB, shards: ["main", "north"] }, NOW_US)[0]).toBe("leads main, north");
  });

  it("is only when it was heard, once it is gone", () => {
    expect(hubFacts({ ...HUB, role: "gone", silent_s: 312 }, NOW_US)).toEqual(["last heard 5 min ago"]);
  });

  it("is that the database does not answer, where that is so", () => {
    expect(hubFacts({ ...HUB, database_ms: 0 }, NOW_US)).toContain("no answer from the database");
  });
});
