import { describe, expect, test } from "vitest";
import type { GraphNodeShape } from "../../src/generated/api.js";
import { drawGraph, MOST_BOXES, searchGraph } from "../../src/boards/node-graph.js";

const node = (name: string, publishes: readonly string[], subscribes: readonly string[]): GraphNodeShape => ({ name, publishes, subscribes });
const ROBOT = [
  node("/lidar", ["/scan", "/rosout"], []),
  node("/slam", ["/map", "/rosout"], ["/scan", "/odom"]),
  node("/planner", ["/cmd_vel", "/rosout"], ["/map", "/scan"]),
  node("/base", ["/odom", "/rosout"], ["/cmd_vel"]),
  node("/recorder", [], ["/rosout"]),
];

describe("the graph of a robot's nodes", () => {
  test("stands in as few columns as there are steps from where a way begins, in spite of circles", () => {
    const { boxes, lines, columns } = drawGraph(ROBOT, "", false);
    const names = [0, 1, 2, 3, 4, 5].map((at) => boxes.filter(({ column }) => column === at).map(({ name }) => name).sort());
    expect(lines).toHaveLength(9);
    expect(names).toEqual([["/lidar", "/recorder"], ["/scan"], ["/planner", "/slam"], ["/cmd_vel", "/map"], ["/base"], ["/odom"]]);
    expect(columns).toBe(6);
    const places = boxes.map((box) => `${String(box.column)} ${String(box.row)}`);
    expect(new Set(places).size).toBe(boxes.length);
  });

  test("leaves out what every node has, unless it is wanted", () => {
    expect(drawGraph(ROBOT, "", false).boxes.map(({ key }) => key)).not.toContain("topic /rosout");
    expect(drawGraph(ROBOT, "", true).boxes.map(({ key }) => key)).toContain("topic /rosout");
    expect(drawGraph(ROBOT, "topic /rosout", false).boxes).toHaveLength(6);
  });

  test("around one box has whom it hears and who hears it", () => {
    const { boxes } = drawGraph(ROBOT, "node /slam", false);
    // What it hears stands left of it, and who hears it right.
    const columns = ["/odom", "/slam", "/map", "/planner"].map((name) => boxes.find((box) => box.name === name)?.column ?? -1);
    expect(columns).toEqual([...columns].sort((a, b) => a - b));
    expect(new Set(columns).size).toBe(4);
    expect(boxes.map(({ name }) => name).sort()).toEqual(["/base", "/lidar", "/map", "/odom", "/planner", "/scan", "/slam"]);
  });

  test("of hundreds draws what is joined most, and says how many are left out", () => {
    const many = Array.from({ length: 300 }, (_, n) => node(`/n${String(n)}`, [`/t${String(n)}`], [`/t${String((n + 1) % 300)}`]));
    const { boxes, left } = drawGraph([...many, node("/hub", [], many.map((_, n) => `/t${String(n)}`))], "", false);
    expect(boxes).toHaveLength(MOST_BOXES);
    expect(left).toBe(601 - MOST_BOXES);
    expect(boxes.map(({ name }) => name)).toContain("/hub");
  });

  test("is searched by words, nodes first", () => {
    expect(searchGraph(ROBOT, "la").map(({ key }) => key)).toEqual(["node /slam", "node /planner"]);
    expect(searchGraph(ROBOT, "A M").map(({ name }) => name)).toEqual(["/slam", "/map"]);
  });
});
