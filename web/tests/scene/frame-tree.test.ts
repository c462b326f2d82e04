import { describe, expect, it } from "vitest";
import { FrameTree, type FrameNews } from "../../src/scene/frame-tree.js";

function news(parent: string, child: string, timeUs = 1, x = 1): FrameNews {
  return { parent, child, timeUs, transform: { at: [x, 0, 0], turn: [0, 0, 0, 1] }, source: "tf", fixed: false };
}

describe("a tree of frames", () => {
  it("counts when other frames are there, and not when one that is there is said again", () => {
    const tree = new FrameTree();
    tree.add(news("odom", "base_link"), 0);
    tree.add(news("base_link", "twin/base_link"), 0);
    const { version } = tree;
    for (let us = 2; us < 50; us += 1) tree.add(news("odom", "base_link", us), us);
    expect(tree.version).toBe(version);
    tree.add(news("map", "base_link", 50), 50);
    expect(tree.version).toBeGreaterThan(version);
    expect([...tree.names()].sort()).toEqual(["base_link", "map", "odom", "twin/base_link"]);
  });

  it("takes no frame that would stand in itself", () => {
    const tree = new FrameTree();
    tree.add(news("a", "b"), 0);
    tree.add(news("b", "c"), 0);
    tree.add(news("c", "a"), 0);
    expect(tree.find("a", "c", Infinity)?.at).toEqual([2, 0, 0]);
    expect(tree.rows(0).map(({ name }) => name)).toEqual(["a", "b", "c"]);
  });

  it("says which frames nothing stands under, and how old what moves is", () => {
    const tree = new FrameTree();
    tree.add(news("odom", "base_link"), 1000);
    tree.add({ ...news("base_link", "laser"), fixed: true }, 1000);
    tree.add(news("earth", "map"), 3000);
    expect(tree.roots()).toEqual(["earth", "odom"]);
    expect(["base_link", "laser", "odom", "nowhere"].map((name) => tree.ageOf(name, 4000))).toEqual([3, null, null, null]);
  });

  it("says where a frame was as long as scans may be of then, and not for ever", () => {
    const tree = new FrameTree();
    // Ten times a second for a minute; it moves by a centimetre each time.
    for (let tenth = 0; tenth <= 600; tenth += 1) tree.add(news("odom", "base_link", tenth * 1e5, tenth / 100), tenth * 100);
    expect(tree.find("odom", "base_link", 55e6)?.at[0]).toBeCloseTo(5.5, 6);
    // What was forgotten is answered with the oldest that is known, and that is not older than the rest by much.
    const oldest = tree.find("odom", "base_link", 0)?.at[0] ?? 0;
    expect(oldest).toBeGreaterThan(4);
    expect(oldest).toBeLessThanOrEqual(5);
  });

  it("leaves out what is no place", () => {
    const tree = new FrameTree();
    tree.add(news("odom", "base_link", 1, Number.NaN), 0);
    tree.add(news("odom", "base_link", 1, Infinity), 0);
    expect(tree.has("base_link")).toBe(false);
  });
});
