import { expect, test } from "vitest";
import { severityOf } from "../../src/format/severity.js";

test.each([
  ["warning", "warn"], ["WARN: battery low", "warn"], ["[WARNING] dome is parked", "warn"], ["Caution", "warn"],
  ["error", "bad"], ["[ERROR] no answer", "bad"], ["unsafe", "bad"], ["alert", "bad"],
  ["safe", ""], ["idle", ""], ["no warning", ""], ["errors: 0", ""], ["warned", ""], ["", ""],
])("“%s” has the level “%s”", (text, level) => {
  expect(severityOf(text)).toBe(level);
});
