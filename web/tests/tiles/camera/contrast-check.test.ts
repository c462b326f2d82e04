import { expect, it } from "vitest";
import { showsSomething } from "../../../src/tiles/camera/contrast-check.js";

function pixels(light: (at: number) => number): Uint8ClampedArray {
  return new Uint8ClampedArray(32 * 24 * 4).map((_, at) => (at % 4 === 3 ? 255 : light(at >> 2)));
}

it("takes an even grey area for no picture", () => {
  expect(showsSomething(pixels(() => 128))).toBe(false);
  expect(showsSomething(pixels(() => 0))).toBe(false);
  expect(showsSomething(pixels((at) => 126 + (at % 4)))).toBe(false);
});

it("takes a dim room with one lamp for a picture", () => {
  expect(showsSomething(pixels((at) => (at === 300 ? 40 : 8)))).toBe(true);
});
