import { expect, test } from "vitest";
import { checkArgument, argumentLimitText, initialText } from "../../../src/elements/command/argument-check.js";
import type { ArgumentShape } from "../../../src/generated/api.js";

function argument(more: Partial<ArgumentShape> = {}): ArgumentShape {
  return { id: "a", name: "A", type: "number", unit: "°", minimum: 0, maximum: 360, max_length: 200, default: null, ...more };
}

test("a number is read with point or comma", () => {
  expect(checkArgument(argument(), " 12.5 ")).toEqual({ ok: true, value: 12.5 });
  expect(checkArgument(argument(), "12,5")).toEqual({ ok: true, value: 12.5 });
});

test.each(["", "abc", "NaN", "Infinity", "1e999"])("%j is no number", (text) => {
  expect(checkArgument(argument(), text)).toEqual({ ok: false, why: "A number is needed here." });
});

test("a number outside its limits is told them", () => {
  expect(checkArgument(argument(), "361")).toEqual({ ok: false, why: "It may be 0 to 360\u202f°." });
  expect(checkArgument(argument({ maximum: null }), "-1")).toMatchObject({ ok: false });
});

test("a whole number has no part after the point", () => {
  expect(checkArgument(argument({ type: "integer" }), "2.5")).toMatchObject({ ok: false });
  expect(checkArgument(argument({ type: "integer" }), "2")).toEqual({ ok: true, value: 2 });
});

test("a boolean is one, a text is not too long", () => {
  expect(checkArgument(argument({ type: "boolean" }), "true")).toEqual({ ok: true, value: true });
  expect(checkArgument(argument({ type: "boolean" }), "false")).toEqual({ ok: true, value: false });
  expect(checkArgument(argument({ type: "text" }), "x".repeat(201))).toMatchObject({ ok: false });
});

test.each([
  ["numbers", "1, -2.5, 1e3"],
  ["numbers", "[1, 2]"],
  ["numbers", ""],
  ["integers", "9223372036854775807, 2"],
  ["booleans", "true, Off"],
  ["texts", "front left, 12"],
  ["texts", '["a, b", ""]'],
  ["bytes", "0, 255"],
] as const)("a list of %s is sent as it was typed: %s", (type, text) => {
  expect(checkArgument(argument({ type, minimum: null, maximum: null }), ` ${text} `)).toEqual({ ok: true, value: text });
});

test.each([
  ["numbers", "1, two", "Item 2: a number is needed."],
  ["numbers", "1,,2", "Item 2: a number is needed."],
  ["integers", "1.5", "Item 1: a whole number is needed."],
  ["booleans", "1", "Item 1: true or false is needed."],
  ["texts", "[1]", "Item 1: a text is needed."],
  ["bytes", "256", "Item 1: a whole number from 0 to 255 is needed."],
  ["numbers", "[1, 2", "It begins with [ but is no JSON list."],
] as const)("a list of %s that does not fit is told its place: %s", (type, text, why) => {
  expect(checkArgument(argument({ type, minimum: null, maximum: null }), text)).toEqual({ ok: false, why });
});

test("the limits of a list are those of its items", () => {
  const why = "Item 2: a number, 0 to 360\u202f°, is needed.";
  expect(checkArgument(argument({ type: "numbers" }), "1, 361")).toEqual({ ok: false, why });
});

test("limits are said in words", () => {
  expect(argumentLimitText(argument({ maximum: null }))).toBe("0\u202f° or more");
  expect(argumentLimitText(argument({ minimum: null, maximum: 0.25, unit: "m" }))).toBe("0.25\u202fm or less");
  expect(argumentLimitText(argument({ minimum: null, maximum: null }))).toBe("");
});

test("a field starts with the description's default", () => {
  expect(initialText(argument({ default: 180 }))).toBe("180");
  expect(initialText(argument())).toBe("");
  expect(initialText(argument({ type: "boolean" }))).toBe("false");
});
