import { describe, expect, it } from "vitest";
import { offeredVersions, phaseWords, rolloutWords, stageStatus } from "../../../src/pages/gateways/release-words.js";
import type { GatewayReleaseShape, ReleaseShape, RolloutShape } from "../../../src/generated/api.js";

const GATEWAY: GatewayReleaseShape = { site: "dome", current: "1.0.0", phase: "idle", candidate: "", waits: "", fetched: 0, failed: {} };
const RELEASE: ReleaseShape = { name: "a.release", version: "1.1.0", site: "", size: 100, changed_us: 0, problem: "" };
const ROLLOUT: RolloutShape = {
  version: "1.1.0", who: "ada", began_us: 0, first: 1, at_once: 10, runs: true, stopped: "",
  sites: [{ site: "dome", stage: "done", why: "" }, { site: "rover", stage: "queued", why: "" }],
};

describe("what is said of releases", () => {
  it("is why a gateway does not change yet, and how far it has fetched", () => {
    expect(phaseWords(GATEWAY)).toBe("");
    expect(phaseWords({ ...GATEWAY, phase: "waiting", candidate: "1.1.0", waits: "it is driven" })).toBe("1.1.0 is installed and waits: it is driven");
    expect(phaseWords({ ...GATEWAY, phase: "fetching", candidate: "1.1.0", fetched: 45 }, 100)).toBe("fetches 1.1.0: 45 %");
  });

  it("is how many run it, and why it stopped", () => {
    expect(rolloutWords(ROLLOUT)).toBe("On its way: 1 of 2 gateways run it.");
    expect(rolloutWords({ ...ROLLOUT, runs: false, stopped: "rover: no link" })).toBe("Stopped: rover: no link. 1 of 2 gateways run it.");
    expect(stageStatus("queued", true)[1]).toBe("was not offered it");
  });

  it("offers each version to those that it is for and that do not run it", () => {
    const rover = { ...GATEWAY, site: "rover", current: "1.1.0" };
    const releases = [RELEASE, { ...RELEASE, version: "1.2.0", site: "rover" }, { ...RELEASE, version: "2.0.0", problem: "broken" }];
    expect([...offeredVersions({ releases, gateways: [GATEWAY, rover], rollout: null })]).toEqual([["1.1.0", ["dome"]], ["1.2.0", ["rover"]]]);
  });
});
