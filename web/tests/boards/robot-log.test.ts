import { describe, expect, it } from "vitest";
import { RobotLog } from "../../src/boards/robot-log.js";
import { roomFor, xyPairs } from "../../src/boards/xy-pairs.js";

const line = (level: number, name: string, msg: unknown): object => ({ level, name, msg, stamp: { sec: 5, nanosec: 500_000_000 } });
const all = { level: 0, node: "", words: "" };

describe("a robot's log", () => {
  it("is filtered by level, node and words, the newest first", () => {
    const log = new RobotLog();
    for (const said of [line(20, "nav", "goal reached"), line(40, "driver", "motor 2 hot"), line(40, "nav", { $text: "no path", $of: 9000 }), "no line", {}]) log.addMessage(said);
    expect(log.size).toBe(3);
    expect(log.linesFor(all, 9).map(({ message }) => message)).toEqual(["no path…", "motor 2 hot", "goal reached"]);
    expect(log.linesFor({ level: 40, node: "driv", words: "HOT motor" }, 9).map(({ node, timeUs }) => [node, timeUs])).toEqual([["driver", 5_500_000]]);
    expect(log.linesFor(all, 1)).toHaveLength(1);
  });

  it("keeps so many lines and says how many went", () => {
    const log = new RobotLog();
    for (let i = 0; i < 2010; i += 1) log.addMessage(line(20, "n", String(i)));
    expect([log.size, log.dropped]).toEqual([2000, 10]);
  });
});

describe("an X-Y plot", () => {
  it("joins what was known at one moment, and nothing that was too old by then", () => {
    const across = { times: [0, 10, 20, 30, 90], values: [1, 2, 3, Number.NaN, 5] };
    const upwards = { times: [5, 18], values: [7, 8] };
    expect(xyPairs(across, upwards, 0, 20)).toEqual([{ x: 2, y: 7 }, { x: 3, y: 8 }]);
    expect(xyPairs(across, upwards, 15, 20)).toEqual([{ x: 3, y: 8 }]);
    expect(roomFor([2, 2])).toEqual([1, 3]);
  });
});
