import { describe, expect, test } from "vitest";
import { meaningOf, sourceOf, usesKeys, type KeyPress } from "../../../src/controllers/drive/drive-keys.js";

function press(code: string, key: string, more: Partial<KeyPress> = {}): KeyPress {
  const plain = { repeat: false, ctrlKey: false, altKey: false, metaKey: false, isComposing: false };
  return { code, key, ...plain, ...more };
}

test.each([
  ["KeyW", "w", "forward"],
  ["KeyX", "x", "backward"],
  ["KeyA", "a", "left"],
  ["KeyD", "D", "right"],
  ["ArrowUp", "ArrowUp", "forward"],
  ["ArrowDown", "ArrowDown", "backward"],
  ["ArrowLeft", "ArrowLeft", "left"],
  ["ArrowRight", "ArrowRight", "right"],
])("%s pushes %s", (code, key, direction) => {
  expect(meaningOf(press(code, key))).toEqual({ kind: "push", direction });
});

test("s halts, plus and minus change the speed, Escape is STOP", () => {
  expect(meaningOf(press("KeyS", "s"))).toEqual({ kind: "halt" });
  expect(meaningOf(press("BracketRight", "+"))).toEqual({ kind: "faster" });
  expect(meaningOf(press("NumpadSubtract", "-"))).toEqual({ kind: "slower" });
  expect(meaningOf(press("Escape", "Escape"))).toEqual({ kind: "STOP" });
});

test("letters go by what is printed on the key: A on a French keyboard sits at Q", () => {
  expect(meaningOf(press("KeyQ", "a"))).toEqual({ kind: "push", direction: "left" });
});

test("repeats, shortcuts and half-typed characters are not ours", () => {
  expect(meaningOf(press("KeyW", "w", { repeat: true }))).toBeNull();
  expect(meaningOf(press("KeyW", "w", { ctrlKey: true }))).toBeNull();
  expect(meaningOf(press("ArrowLeft", "ArrowLeft", { altKey: true }))).toBeNull();
  expect(meaningOf(press("KeyS", "s", { metaKey: true }))).toBeNull();
  expect(meaningOf(press("KeyA", "a", { isComposing: true }))).toBeNull();
  expect(meaningOf(press("KeyP", "p"))).toBeNull();
});

test("a held key is named by its place, whatever Shift does meanwhile", () => {
  expect(sourceOf({ code: "KeyW" })).toBe("key:KeyW");
});

describe("elements that use keys themselves", () => {
  test("a field being typed in keeps all of them", () => {
    expect(usesKeys([{ tagName: "INPUT", type: "text" }], "KeyW")).toBe(true);
    expect(usesKeys([{ tagName: "INPUT", type: "number" }], "KeyW")).toBe(true);
    expect(usesKeys([{ tagName: "TEXTAREA" }], "KeyW")).toBe(true);
    expect(usesKeys([{ tagName: "SELECT" }], "KeyW")).toBe(true);
    expect(usesKeys([{ tagName: "DIV", isContentEditable: true }], "KeyW")).toBe(true);
  });

  test("a slider keeps the arrows only, and so does a map", () => {
    expect(usesKeys([{ tagName: "INPUT", type: "range" }], "ArrowUp")).toBe(true);
    expect(usesKeys([{ tagName: "INPUT", type: "range" }], "KeyW")).toBe(false);
    expect(usesKeys([{ tagName: "DIV" }, { dataset: { keys: "own" } }], "ArrowUp")).toBe(true);
    expect(usesKeys([{ tagName: "DIV" }, { dataset: { keys: "own" } }], "KeyW")).toBe(false);
  });

  test("a button does not", () => {
    expect(usesKeys([{ tagName: "BUTTON" }, { tagName: "BODY" }, {}], "ArrowUp")).toBe(false);
  });
});
