import { expect, test } from "vitest";
import { pictureState } from "../../../src/elements/camera/picture-state.js";

const SEEN = { still: false, drawn: true, isOpen: true, ageMs: 100 };

test("a picture is live while it is young and comes over an open line", () => {
  expect(pictureState(SEEN)).toBe("live");
  expect([pictureState({ ...SEEN, ageMs: 501 }), pictureState({ ...SEEN, ageMs: NaN }), pictureState({ ...SEEN, isOpen: false })]).toEqual(["old", "old", "old"]);
  expect(pictureState({ ...SEEN, drawn: false })).toBe("none");
});

test("a finished exposure is never frozen, however old it is, and never live", () => {
  for (const ageMs of [0, 501, 3_600_000, NaN]) expect(pictureState({ ...SEEN, still: true, ageMs })).toBe("exposure");
  expect(pictureState({ ...SEEN, still: true, isOpen: false })).toBe("exposure");
  expect(pictureState({ ...SEEN, still: true, drawn: false })).toBe("none");
});
