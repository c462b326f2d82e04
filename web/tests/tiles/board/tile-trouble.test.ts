import { expect, test } from "vitest";
import type { SiteShape } from "../../../src/generated/api.js";
import type { BoardTileContext, BoardTileEntry } from "../../../src/tiles/board/board-tile-entry.js";
import { missingNames, tileTrouble } from "../../../src/tiles/board/tile-trouble.js";

const device = { id: "base", kind: "vehicle", signals: [{ id: "speed", address: "base/speed", role: "" }], streams: [{ id: "front", address: "base/front" }], commands: [] };
const context = { detail: { site: "agv", devices: [device] } as unknown as SiteShape, device: null, extensions: [] } as unknown as BoardTileContext;
const chart = { settings: [{ key: "signals", label: "Signals", kind: "signals", needed: true }] } as unknown as BoardTileEntry;
const wall = { settings: [{ key: "streams", label: "Cameras", kind: "streams" }] } as unknown as BoardTileEntry;

test("a tile that names some things which are not there is drawn without them, and says so", () => {
  const settings = { signals: ["base/speed", "base/removed", "@battery.level"] };
  expect(tileTrouble(chart, settings, context)).toBeNull();
  expect(missingNames(chart, settings, context)).toEqual(["base/removed", "@battery.level"]);
  expect(missingNames(wall, { streams: ["base/front", "mast/sky"] }, context)).toEqual(["mast/sky"]);
});

test("where nothing is there, that is said in the tile's place alone", () => {
  expect(tileTrouble(chart, { signals: ["base/removed"] }, context)?.kind).toBe("forbidden");
  expect(missingNames(chart, { signals: ["base/removed"] }, context)).toEqual([]);
  expect(missingNames(chart, { signals: ["base/speed"] }, context)).toEqual([]);
});
