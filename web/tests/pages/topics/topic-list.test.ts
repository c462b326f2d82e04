import { expect, test } from "vitest";
import type { TopicShape } from "../../../src/generated/api.js";
import { filterTopics, rateText, whoMaySee } from "../../../src/pages/topics/topic-list.js";
import { offeredTiles } from "../../../src/tiles/topic/topic-tiles.js";

const topic = (name: string, more: Partial<TopicShape> = {}): TopicShape => ({
  topic: name, type: "std_msgs/msg/String", latched: false, max_rate: 0, problem: "", described: true, right: "view", device: "", rate: 0, ...more,
});

test("who may see a topic is said in words", () => {
  expect(whoMaySee(topic("/a"), undefined)).toBe("who may view the site");
  expect(whoMaySee(topic("/a", { right: "use", device: "base" }), undefined)).toBe("who may use base");
  expect(whoMaySee(topic("/a", { right: "admin" }), undefined)).toBe("admins");
  expect(whoMaySee(topic("/a", { right: "tap", described: false }), undefined)).toBe("admins, and who may tap");
});

test("rates are said as people say them", () => {
  expect([null, 0, 0.02, 0.5, 9.96, 99.7].map(rateText)).toEqual(["", "", "every 50 s", "0.5 Hz", "10.0 Hz", "100 Hz"]);
});

test("all words of a filter stand in the name or the type", () => {
  const all = [topic("/scan", { type: "sensor_msgs/msg/LaserScan" }), topic("/said")];
  expect(filterTopics(all, "sc laser").map((one) => one.topic)).toEqual(["/scan"]);
  expect(filterTopics(all, " ")).toHaveLength(2);
});

test("tiles are offered of described topics whose type has one, aggregated diagnostics first", () => {
  const type = "diagnostic_msgs/msg/DiagnosticArray";
  const all = [
    topic("/diagnostics", { type }),
    topic("/diagnostics_agg", { type }),
    topic("/other", { type, described: false }),
    topic("/broken", { type, problem: "its type is not known" }),
    topic("/said"),
  ];
  expect(offeredTiles(all).map((one) => one.topic)).toEqual(["/diagnostics_agg", "/diagnostics"]);
});
