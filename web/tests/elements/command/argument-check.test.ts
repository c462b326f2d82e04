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
