import { describe, expect, it } from "vitest";
import { partAt, placeOf } from "../../../src/elements/camera/picture-fit.js";
import { sideSpots } from "../../../src/elements/camera/mark-shapes.js";
import type { JsonObject } from "../../../src/pages/description/json-schema.js";
import { ShapeDraft } from "../../../src/pages/zones/shape-draft.js";
import { gapsOf, movedShape, newShape, readShapes, reversedShape, withoutPoint, withPointAfter, withShapes, type DrawnShape } from "../../../src/pages/zones/zone-shapes.js";

const DOOR = { name: "Door", points: [[0.1, 0.9], [0.4, 0.6]] };
const MAT = { name: "Mat", points: [[0.3, 0.6], [0.6, 0.6], [0.7, 1]] };
const SITE: JsonObject = {
  name: "Hall",
  devices: {
    gate: {
      name: "Gate",
      streams: { road: { name: "Road", detect: { classes: ["person", "car"], zones: { mat: MAT }, lines: { door: DOOR } } }, yard: { name: "Yard" } },
      signals: {
        on_mat: { name: "On the mat", source: { stream: "road", sees: "person", zone: "mat" } },
        came_in: { name: "Came in", source: { stream: "road", sees: "person", line: "door", measure: "left" } },
        persons: { name: "Persons", source: { stream: "road", sees: "person" } },
      },
    },
  },
};
const at = (site: JsonObject, ...path: string[]): unknown => path.reduce<unknown>((value, key) => (value as Record<string, unknown>)[key], site);
const gate = (site: JsonObject, ...path: string[]): unknown => at(site, "devices", "gate", ...path);

describe("zones and lines that are drawn", () => {
  it("are those of the description, and written back change nothing of it", () => {
    const shapes = readShapes(SITE, "gate/road");
    expect(shapes.map(({ kind, id, name }) => [kind, id, name])).toEqual([["zone", "mat", "Mat"], ["line", "door", "Door"]]);
    expect(withShapes(SITE, "gate/road", shapes)).toEqual(SITE);
  });

  it("bring signals that count at what is new, under keys of their own", () => {
    const shapes = readShapes(SITE, "gate/road");
    const drawn: DrawnShape = { ...newShape("line", "car", shapes), name: " Mat" };
    const made = withShapes(SITE, "gate/road", [...shapes, drawn]);
    expect(Object.keys(gate(made, "streams", "road", "detect", "lines") as object)).toEqual(["door", "mat2"]);
    expect(gate(made, "signals", "mat2_left")).toEqual({ name: "Mat: car, to the left", source: { stream: "road", sees: "car", line: "mat2", measure: "left" } });
    expect(gate(made, "signals", "mat2_right")).toBeDefined();
    const zone = withShapes(SITE, "gate/yard", [newShape("zone", "person", [])]);
    expect(gate(zone, "signals", "zone_1_dwell")).toEqual({ name: "Zone 1: person, longest", unit: "s", source: { stream: "yard", sees: "person", zone: "zone_1", measure: "dwell" } });
  });

  it("take the signals that counted at them along when they go, and no other", () => {
    const left = readShapes(SITE, "gate/road").filter(({ kind }) => kind === "line");
    const made = withShapes(SITE, "gate/road", left);
    expect(gate(made, "streams", "road", "detect", "zones")).toEqual({});
    expect(Object.keys(gate(made, "signals") as object)).toEqual(["came_in", "persons"]);
  });

  it("stay on the picture, and stay zones and lines", () => {
    const [zone, line] = readShapes(SITE, "gate/road") as [DrawnShape, DrawnShape];
    const placed = movedShape(zone, 0.5, 0.5).points.map((point) => point.map((part) => part.toFixed(3)).join(" "));
    expect(placed).toEqual(["0.600 0.600", "0.900 0.600", "1.000 1.000"]);
    expect(withoutPoint(zone, 0)).toBe(zone);
    expect(withoutPoint(withPointAfter(line, 0), 0).points).toEqual([[0.25, 0.75], [0.4, 0.6]]);
    expect([gapsOf(zone).length, gapsOf(line).length]).toEqual([3, 1]);
    expect(reversedShape(line).points).toEqual([[0.4, 0.6], [0.1, 0.9]]);
  });

  it("are taken back a whole drag at a time", () => {
    const draft = new ShapeDraft(SITE, "gate/road", 1);
    for (let step = 1; step <= 20; step += 1) draft.applyEdit({ what: "move point", shape: 1, point: 0, to: [0.1 + step / 5000, 0.5], along: step > 1 });
    expect(at(draft.described(), "devices", "gate", "streams", "road", "detect", "lines", "door", "points")).toEqual([[0.104, 0.5], [0.4, 0.6]]);
    draft.undoEdit();
    expect([draft.isChanged, draft.canRedo]).toEqual([false, true]);
  });
});

describe("a place of the view", () => {
  it("is the part of the picture that lies there, also looked closer at", () => {
    const view = { width: 390, height: 300 };
    const picture = { width: 1280, height: 720 };
    for (const zoom of [{ scale: 1, x: 0, y: 0 }, { scale: 2.5, x: -0.6, y: -0.2 }]) {
      for (const [x, y] of [[0, 0], [0.3, 0.8], [1, 1]] as const) {
        const [partX, partY] = partAt(placeOf({ left: x, top: y, right: x, bottom: y }, view, picture, zoom), view, picture, zoom);
        expect([partX, partY]).toEqual([expect.closeTo(x), expect.closeTo(y)]);
      }
    }
  });

  it("says left above a way to the right", () => {
    const sides = sideSpots([{ x: 0, y: 50 }, { x: 100, y: 50 }], 20, { x: 50, y: 50 });
    expect([sides.left.y, sides.right.y]).toEqual([30, 70]);
  });
});
