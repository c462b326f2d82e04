import { afterEach, expect, test } from "vitest";
import { intlLocale, useLanguage } from "../../src/words/locale.js";
import { fixedText, formatNumber } from "../../src/format/number.js";
import { plural } from "../../src/words/plural.js";
import { formatDate } from "../../src/format/time.js";

afterEach(() => {
  useLanguage("en");
});

test("one is for exactly one, other for all else", () => {
  expect([0, 1, 2].map((many) => plural(many, "one", "other"))).toEqual(["other", "one", "other"]);
});

test("a translation may have a form for each kind of number", () => {
  useLanguage("ru");
  const forms = [1, 3, 5, 21].map((many) => plural(many, "1 сигнал", `${String(many)} сигнал||${String(many)} сигнала||${String(many)} сигналов||${String(many)} сигнала`));
  expect(forms).toEqual(["1 сигнал", "3 сигнала", "5 сигналов", "21 сигнал"]);
});

test("numbers and dates are written as the language has them", () => {
  expect(intlLocale()).toBe("en-GB");
  expect([formatNumber(-12345.25, 2), fixedText(1.5, 1)]).toEqual(["−12\u202f345.25", "1.5"]);
  useLanguage("ca");
  expect([formatNumber(-12345.25, 2), fixedText(1.5, 1)]).toEqual(["−12\u202f345,25", "1,5"]);
  expect(formatDate(0, "UTC")).toContain("gen");
});
