import { expect, test } from "vitest";
import { FieldTraces, KEPT_MS, numberAt } from "../../src/topics/field-traces.js";

const TREE = { twist: { linear: { x: 0.5, y: { $number: "nan" } } }, on: true, name: "base", shelves: { $first: [{ celsius: 4 }, { celsius: 7 }], $of: 900 } };

test("a number is found by the path that the tree shows, of long arrays, too", () => {
  expect(numberAt(TREE, "twist.linear.x")).toBe(0.5);
  expect(numberAt(TREE, "shelves[1].celsius")).toBe(7);
  expect(numberAt(TREE, "on")).toBe(1);
});

test("what is no number, or not there, is none", () => {
  for (const path of ["name", "twist", "twist.linear.y", "twist.linear.x.deeper", "shelves[7].celsius", "gone"]) expect(numberAt(TREE, path)).toBeNull();
});

test("fields are kept for a minute, each as long as it is chosen", () => {
  const plots = new FieldTraces();
  plots.choose(["twist.linear.x"]);
  plots.addMessage(TREE, 0);
  plots.addMessage({}, 10);
  plots.addMessage(TREE, KEPT_MS);
  plots.toggle("on");
  plots.addMessage(TREE, KEPT_MS + 1);
  expect(plots.traces).toEqual([
    { path: "twist.linear.x", points: [{ atMs: KEPT_MS, value: 0.5 }, { atMs: KEPT_MS + 1, value: 0.5 }] },
    { path: "on", points: [{ atMs: KEPT_MS + 1, value: 1 }] },
  ]);
  plots.toggle("twist.linear.x");
  expect(plots.paths).toEqual(["on"]);
});

test("of more fields than have a colour the oldest goes, and another topic begins anew", () => {
  const plots = new FieldTraces();
  for (const path of ["on", "b", "c", "d", "e"]) plots.toggle(path);
  expect(plots.paths).toEqual(["b", "c", "d", "e"]);
  plots.choose(["on"]);
  plots.addMessage(TREE, 0);
  plots.clear();
  expect(plots.traces).toEqual([{ path: "on", points: [] }]);
});
