import { describe, expect, it } from "vitest";
import { differenceLines, differenceText } from "../../../src/format/unified-diff.js";
import { changedAt, emptyOf, schemaFields, freeName, movedAt, pathOf, renamedAt, type JsonObject } from "../../../src/pages/description/json-schema.js";
import { EditHistory } from "../../../src/state/edit-history.js";

const ROOT = {
  $ref: "#/$defs/Site",
  $defs: {
    Site: {
      type: "object",
      properties: {
        zone: { type: "string", default: "UTC" },
        name: { type: "string" },
        devices: { type: "object", additionalProperties: { $ref: "#/$defs/Device" }, default: {} },
        place: { anyOf: [{ $ref: "#/$defs/Place" }, { type: "null" }], default: null },
      },
      required: ["name"],
    },
    Device: {
      type: "object",
      properties: {
        name: { type: "string" },
        kind: { $ref: "#/$defs/Kind", default: "other" },
        low: { anyOf: [{ type: "number" }, { type: "null" }], default: null, description: "the least" },
      },
      required: ["name"],
    },
    Kind: { enum: ["dome", "other"] },
    Place: { type: "object", properties: { latitude: { type: "number" } }, required: ["latitude"] },
  },
};
const SITE: JsonObject = { name: "S", devices: { base: { name: "Base", signals: { speed: { name: "Speed" }, mode: { name: "Mode" } } } } };

describe("a form made of a schema", () => {
  it("has a line for each property, what must be said first", () => {
    const fields = schemaFields(ROOT, ROOT);
    expect(fields.map((field) => [field.key, field.kind, field.required])).toEqual([
      ["name", "text", true],
      ["zone", "text", false],
      ["devices", "parts", false],
      ["place", "part", false],
    ]);
  });

  it("follows references, and tells choices and help", () => {
    const device = schemaFields(ROOT, { $ref: "#/$defs/Device" });
    expect(device[1]).toMatchObject({ key: "kind", kind: "choice", choices: ["dome", "other"], standard: "other" });
    expect(device[2]).toMatchObject({ key: "low", kind: "number", nullable: true, help: "the least" });
  });

  it("begins a new part with the least it has to say", () => {
    expect(emptyOf(ROOT, { $ref: "#/$defs/Device" }, "rain_gauge")).toEqual({ name: "Rain gauge" });
  });
});

describe("a change by path", () => {
  it("sets and takes away without touching the rest", () => {
    const set = changedAt(SITE, ["devices", "base", "name"], "B");
    expect(set).toMatchObject({ devices: { base: { name: "B", signals: { speed: { name: "Speed" } } } } });
    expect(SITE).toMatchObject({ devices: { base: { name: "Base" } } });
    expect(changedAt(SITE, ["devices", "base"], undefined)).toEqual({ name: "S", devices: {} });
  });

  it("lets a renamed signal say what it was, at its place", () => {
    const made = renamedAt(SITE, ["devices", "base", "signals", "speed"], "velocity") as never;
    expect(Object.entries(made["devices"]["base"]["signals"])).toEqual([
      ["velocity", { name: "Speed", was: "speed" }],
      ["mode", { name: "Mode" }],
    ]);
  });

  it("gives no part the name of another", () => {
    expect(renamedAt(SITE, ["devices", "base", "signals", "speed"], "mode")).toBe(SITE);
    expect(freeName({ new_signal: 1, new_signal2: 1 }, "new_signal")).toBe("new_signal3");
  });

  it("moves a part among the others, and not beyond them", () => {
    const made = movedAt(SITE, ["devices", "base", "signals", "mode"], -1) as never;
    expect(Object.keys(made["devices"]["base"]["signals"])).toEqual(["mode", "speed"]);
    expect(movedAt(SITE, ["devices", "base", "signals", "mode"], 1)).toBe(SITE);
  });

  it("reads the path of a finding", () => {
    expect(pathOf("$.devices.base.drive.stop.confirmed_by[0]")).toEqual(["devices", "base", "drive", "stop", "confirmed_by", "0"]);
    expect(pathOf("line 3, column 1")).toEqual([]);
  });
});

describe("what was done to a text", () => {
  it("is taken back and done again", () => {
    const edits = new EditHistory("a");
    edits.recordEdit("b");
    edits.recordEdit("c");
    edits.undoEdit();
    expect(edits.text).toBe("b");
    edits.redoEdit();
    expect(edits.text).toBe("c");
    edits.undoEdit();
    edits.recordEdit("d");
    expect(edits.canRedo).toBe(false);
    edits.undoEdit();
    edits.undoEdit();
    edits.undoEdit();
    expect([edits.text, edits.canUndo]).toEqual(["a", false]);
  });

  it("takes typing back in one step", () => {
    const edits = new EditHistory("");
    edits.recordEdit("x");
    edits.recordEdit("xy", true);
    edits.recordEdit("xyz", true);
    edits.undoEdit();
    expect(edits.text).toBe("");
  });
});

describe("a difference in lines", () => {
  const lines = differenceLines(["@@ -3,2 +3,3 @@", " same", "-old", "+new", "+more"]);

  it("has signs beside colours, and numbers", () => {
    expect(lines.map((line) => [line.kind, line.sign, line.before, line.after])).toEqual([
      ["place", "…", 0, 0],
      ["same", " ", 3, 3],
      ["removed", "−", 4, 0],
      ["added", "+", 0, 4],
      ["added", "+", 0, 5],
    ]);
  });

  it("is said in words", () => {
    expect(differenceText(lines)).toBe("2 lines added, 1 line removed");
    expect(differenceText([])).toBe("no line differs");
  });
});
