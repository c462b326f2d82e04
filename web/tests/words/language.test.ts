import { expect, test } from "vitest";
import { languageFor, languageName } from "../../src/words/language.js";

const THERE = ["en", "ca", "es", "pt-BR"];

test("what was chosen comes before what the browser speaks", () => {
  expect(languageFor("ca", ["es-ES"], THERE)).toBe("ca");
});

test("the first language of the browser that is there is taken, whatever its country", () => {
  expect(languageFor(null, ["fr-FR", "es-MX", "ca"], THERE)).toBe("es");
  expect(languageFor(null, ["pt-br"], THERE)).toBe("pt-BR");
});

test("a language that is gone, or none that is known, is English", () => {
  expect(languageFor("de", ["fr"], THERE)).toBe("en");
});

test("a language is called by its own name", () => {
  expect(["en", "ca", "es"].map(languageName)).toEqual(["English", "Català", "Español"]);
});
