import { expect, test } from "vitest";
import { lifecycleParts, parameterParts } from "../../../src/tiles/board/node-board-tiles.js";
import { command, device, signal, state } from "../observatory/described.js";

const need = (channel: string): { channel: string; max_age: number; states: string[]; among: string[] } => ({ channel, max_age: 5, states: [], among: [] });
const driver = device(
  "other",
  [signal("speed"), signal("limit", { ros: "parameter" }), state("driver", ["inactive", "active"], { ros: "lifecycle" })],
  [
    command("set_limit", [], { ros: "parameter" }),
    command("activate", [], { ros: "lifecycle", needs: need("it/driver") }),
    command("wake", [], { ros: "lifecycle" }),
    command("horn"),
  ],
);
const named = (parts: ReturnType<typeof parameterParts>): unknown => parts.map(({ signal: said, commands }) => [said?.id ?? null, commands.map(({ id }) => id)]);

test("parameters stand with what sets them, and nothing else of the device", () => {
  expect(named(parameterParts([driver]))).toEqual([
    ["limit", []],
    [null, ["set_limit"]],
  ]);
});

test("a node's transitions stand at its state; those of a node whose state nobody may see are not lost", () => {
  expect(named(lifecycleParts([driver]))).toEqual([
    ["driver", ["activate"]],
    [null, ["wake"]],
  ]);
  const hidden = { ...driver, signals: [] };
  expect(named(lifecycleParts([hidden]))).toEqual([[null, ["activate", "wake"]]]);
});
