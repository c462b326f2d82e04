import { describe, expect, it } from "vitest";
import { pathBox, pathPoses, pathStretches, verdictLines } from "../../src/scene/rehearsal.js";
import { ghostFrames } from "../../src/scene/scene-topics.js";
import type { RehearsalVerdict } from "../../src/generated/wire.js";

const PATH = [0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 1.5];
const verdict = (at: number, why: string, share = 1): RehearsalVerdict => ({ t: "verdict", at, why, share });

describe("a rehearsal's path", () => {
  it("has a pose for each three numbers, and none for a rest", () => {
    expect(pathPoses([...PATH, 7], "odom")).toHaveLength(4);
    expect(pathPoses(PATH, "odom").at(-1)).toEqual({ frame: "odom", x: 3, y: 0, yaw: 1.5 });
  });

  it("is cut where the verdict changes, without holes between", () => {
    const poses = pathPoses(PATH, "odom");
    const found = pathStretches(poses, [verdict(1, "Rain: wet"), verdict(2, "")]);
    expect(found.map(({ why, points }) => [why, points.map(({ x }) => x)])).toEqual([["", [0, 1]], ["Rain: wet", [1, 2]], ["", [2, 3]]]);
  });

  it("is drawn in a square that holds all of it", () => {
    for (const path of [[], PATH, [5, -80, 0, 5, 80, 0]]) {
      const poses = pathPoses(path, "odom");
      const { x, y, size } = pathBox(poses);
      expect(poses.every((pose) => pose.x > x && pose.x < x + size && pose.y > y && pose.y < y + size)).toBe(true);
      expect(size).toBeGreaterThanOrEqual(1);
    }
  });

  it("says each reason once, and nothing where nothing would have been refused", () => {
    expect(verdictLines({ verdicts: [] })).toEqual([]);
    expect(verdictLines({ verdicts: [verdict(0, "Rain: wet"), verdict(1, ""), verdict(2, "Rain: wet"), verdict(3, "", 0.4)] })).toEqual([
      "Driving would have been refused: Rain: wet",
      "Speed would have been cut to 40 %",
    ]);
  });
});

describe("ghosts", () => {
  it("are the bodies under a name of their own, and not the robot's", () => {
    expect(ghostFrames(["odom", "base_link", "twin/base_link", "twin/base_scan", "a/b/base_link"])).toEqual(["twin/base_link"]);
  });
});
