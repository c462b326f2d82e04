import { expect, test } from "vitest";
import { nightWindow, placeBlocks, placeMoment, proposalMarks, stepBlock, timeByProposal, type NightBlock } from "../../src/series/plan-layout.js";

const HOUR = 3_600_000;
const NIGHT = { from: 18 * HOUR, to: 30 * HOUR };

function block(id: string, startHour: number, endHour: number, more: Partial<NightBlock> = {}): NightBlock {
  return { id, request: id, name: id, proposal: "P1", startMs: startHour * HOUR, endMs: endHour * HOUR, state: "planned", reason: "", ...more };
}

test("blocks stand in order as parts of the night, and what lies outside is cut or left away", () => {
  const placed = placeBlocks([block("b", 24, 27), block("a", 17, 21), block("gone", 10, 12), block("late", 31, 32)], NIGHT);
  expect(placed.map(({ id, left, width }) => [id, left, width])).toEqual([["a", 0, 0.25], ["b", 0.5, 0.25]]);
});

test("a moment outside the night has no place on it", () => {
  expect(placeMoment(24 * HOUR, NIGHT)).toBe(0.5);
  expect(placeMoment(17 * HOUR, NIGHT)).toBeNull();
  expect(placeMoment(Number.NaN, NIGHT)).toBeNull();
});

test("the window holds the night and every block, in whole half hours", () => {
  const { from, to } = nightWindow({ from: 18.2 * HOUR, to: 30 * HOUR }, [block("flats", 17.4, 17.9)]);
  expect(from).toBeLessThan(17.4 * HOUR);
  expect(to).toBeGreaterThan(30 * HOUR);
  expect([from % (HOUR / 2), to % (HOUR / 2)]).toEqual([0, 0]);
});

test("a proposal keeps its mark whatever comes first, and more than 26 go on with two letters", () => {
  expect(proposalMarks(["b", "a", "b"])).toEqual(proposalMarks(["a", "b"]));
  const many = proposalMarks(Array.from({ length: 30 }, (_, i) => `p${String(i).padStart(2, "0")}`));
  expect(many.get("p25")).toEqual({ letter: "Z", colour: 2 });
  expect(many.get("p26")?.letter).toBe("AA");
  expect(new Set([...many.values()].map(({ letter }) => letter)).size).toBe(30);
});

test("arrows lead from block to block and stop at the ends", () => {
  const blocks = [block("a", 18, 19), block("b", 19, 20), block("c", 20, 21)];
  const step = (id: string, key: string): string | undefined => stepBlock(blocks, id, key)?.id;
  expect([step("a", "ArrowRight"), step("c", "ArrowRight"), step("a", "ArrowLeft"), step("b", "Home"), step("b", "End")]).toEqual(["b", "c", "a", "a", "c"]);
  expect(step("", "ArrowRight")).toBe("a");
  expect(step("a", "x")).toBeUndefined();
});

test("what is only planned counts for no proposal", () => {
  const spent = timeByProposal([block("a", 18, 20, { state: "done" }), block("b", 20, 21, { state: "suspended", proposal: "P2" }), block("c", 21, 25)]);
  expect([...spent]).toEqual([["P1", 2 * HOUR], ["P2", HOUR]]);
});
