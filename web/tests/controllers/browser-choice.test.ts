import { expect, test } from "vitest";
import { readBrowserChoice, saveBrowserChoice } from "../../src/controllers/browser-choice.js";

function storage(full = false): Pick<Storage, "getItem" | "setItem"> {
  const kept = new Map<string, string>();
  return {
    getItem: (key) => kept.get(key) ?? null,
    setItem: (key, value) => {
      if (full) throw new DOMException("full", "QuotaExceededError");
      kept.set(key, value);
    },
  };
}

test("a choice is remembered while it is one of the options", () => {
  const kept = storage();
  expect(readBrowserChoice("hand", ["both", "left"], kept)).toBe("both");
  saveBrowserChoice("hand", "left", kept);
  expect(readBrowserChoice("hand", ["both", "left"], kept)).toBe("left");
  expect(readBrowserChoice("hand", ["both", "right"], kept)).toBe("both");
});

test("without storage, or with a full one, the first option stands", () => {
  expect(() => {
    saveBrowserChoice("hand", "left", storage(true));
  }).not.toThrow();
  expect(readBrowserChoice("hand", ["both", "left"], null)).toBe("both");
});
