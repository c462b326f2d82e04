import { describe, expect, it } from "vitest";
import { changedAt, emptyOf, schemaFields, freeName, movedAt, pathOf, renamedAt, type JsonObject } from "../../../src/pages/description/json-schema.js";

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
  it("has one part with the keys of all for what is one of several shapes, and none for one that a word tells apart", () => {
    const shape = (...keys: string[]) => ({ type: "object", properties: Object.fromEntries(keys.map((key) => [key, { type: "string" }])), required: ["stamp"] });
    const union = { anyOf: [{ $ref: "#/$defs/Ros" }, { $ref: "#/$defs/Indi" }] };
    const tagged = { ...union, discriminator: { propertyName: "kind" } };
    const part = { type: "object", properties: { source: { anyOf: [union, { type: "null" }] }, connection: tagged } };
    const root = { $defs: { Ros: shape("topic", "stamp"), Indi: shape("property", "stamp") } };
    const [source, connection] = schemaFields(root, part);
    expect([source?.kind, source?.nullable, connection?.kind]).toEqual(["part", true, "other"]);
    expect(schemaFields(root, source?.schema ?? {}).map((field) => field.key)).toEqual(["stamp", "topic", "property"]);
  });
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
