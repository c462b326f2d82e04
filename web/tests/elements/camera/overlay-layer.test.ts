import { expect, test } from "vitest";
import { cellRuns, colourNumber, coveredClasses, layerWords, namedClasses } from "../../../src/elements/camera/overlay-layer.js";
import type { OverlayLayer } from "../../../src/generated/wire.js";

const NOTHING: OverlayLayer = { t: "layer", rows: 0, columns: 0, runs: new Uint8Array(), near: null, far: null, poses: [], likely: [] };
const ground = { classes: ["background", "floor", "wall"], kind: "segmentation" } as const;

/** Cells row by row, as the gateway packs them. */
function mapOf(rows: readonly (readonly number[])[], more: Partial<OverlayLayer> = {}): OverlayLayer {
  const runs: number[] = [];
  for (const value of rows.flat()) {
    if (runs.at(-1) === value) runs[runs.length - 2] = (runs.at(-2) ?? 0) + 1;
    else runs.push(1, value);
  }
  return { ...NOTHING, rows: rows.length, columns: rows[0]?.length ?? 0, runs: Uint8Array.from(runs), ...more };
}

test("a stretch that goes on in the next row is two", () => {
  expect(cellRuns(mapOf([[0, 1, 1], [1, 1, 2]]))).toEqual([
    { row: 0, column: 0, length: 1, value: 0 },
    { row: 0, column: 1, length: 2, value: 1 },
    { row: 1, column: 0, length: 2, value: 1 },
    { row: 1, column: 2, length: 1, value: 2 },
  ]);
});

test("a stretch that comes in pieces is one", () => {
  expect(cellRuns({ rows: 1, columns: 5, runs: Uint8Array.from([2, 7, 3, 7]) })).toEqual([{ row: 0, column: 0, length: 5, value: 7 }]);
});

test("runs that are more or fewer cells than the map has are no map", () => {
  const { runs } = mapOf([[0, 1], [1, 1]]);
  expect(cellRuns({ rows: 2, columns: 3, runs })).toEqual([]);
  expect(cellRuns({ rows: 1, columns: 2, runs })).toEqual([]);
  expect(cellRuns({ rows: 2, columns: 2, runs: runs.slice(0, 3) })).toEqual([]);
});

test("a class has its name within itself, and what is nothing else has no colour", () => {
  const layer = mapOf([
    [0, 0, 0, 0],
    [1, 0, 0, 2],
    [1, 1, 1, 1],
  ]);
  const [floor, wall] = coveredClasses(ground, layer);
  expect(floor).toMatchObject({ name: "floor", share: 5 / 12, x: 0.5, y: 2.5 / 3 });
  expect(wall).toMatchObject({ name: "wall", x: 3.5 / 4, y: 0.5 });
  expect([0, 1, 2, 3, 255].map((number) => colourNumber(ground, number))).toEqual([0, 2, 3, 0, 0]);
});

test("what hardly covers anything is in words, and not on the picture", () => {
  const row = Array.from({ length: 100 }, (_, at) => (at === 0 ? 2 : 1));
  const layer = mapOf([row]);
  expect(namedClasses(ground, layer).map(({ name }) => name)).toEqual(["floor"]);
  expect(layerWords(ground, layer)).toEqual(["floor 99\u00a0%", "wall 1\u00a0%"]);
});

test("each kind says in words what it draws", () => {
  const likely = [{ t: "likelihood", label: "hall", share: 0.934 }, { t: "likelihood", label: "bath", share: 0.002 }] as const;
  expect(layerWords({ classes: [], kind: "classification" }, { ...NOTHING, likely })).toEqual(["hall 93\u00a0%", "bath <1\u00a0%"]);
  const depth = { classes: [], kind: "depth" } as const;
  expect(layerWords(depth, mapOf([[15, 0]], { near: 0.84, far: 12.4 }))).toEqual(["bright is near, 0.8\u00a0m", "clear is far, 12\u00a0m"]);
  expect(layerWords(depth, mapOf([[15, 0]]))).toEqual(["bright is near", "clear is far"]);
  expect(layerWords(depth, mapOf([[255, 255]]))).toEqual(["no depth"]);
  const people = { classes: ["person"], kind: "keypoints" } as const;
  const pose = { t: "pose", score: 1, left: 0, top: 0, right: 1, bottom: 1, points: [] } as const;
  expect(layerWords(people, { ...NOTHING, poses: [pose, pose] })).toEqual(["2\u00a0× person"]);
  expect(layerWords(people, NOTHING)).toEqual(["nobody seen"]);
});
