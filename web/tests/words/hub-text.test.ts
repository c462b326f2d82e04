import { describe, expect, test } from "vitest";
import { SENTENCES } from "../../src/generated/hub-sentences.js";
import { HubSentences, inPageLanguage } from "../../src/words/hub-text.js";

const own = new HubSentences([
  ["there is no {}", (what) => `no hi ha: ${what}`],
  ["there is no such site", () => "no hi ha aquest lloc"],
  ["{}: no value newer than {} s", (name, age) => `${name}: cap valor de menys de ${age} s`],
  ["the name cannot be used", () => "el nom no es pot fer servir"],
  ["take another", () => "tria'n un altre"],
  ["{} needs its power: {}", (device, why) => `${device} necessita corrent: ${why}`],
  ["{} does not close by itself: {}. The guide says how.", (device, why) => `${device} no es tanca sol: ${why}. La guia diu com.`],
  ["it still moves", () => "encara es mou"],
]);

describe("what the hub says", () => {
  test("is recognised with what is filled in, the narrower sentence first", () => {
    expect(own.textOf("there is no such site")).toBe("no hi ha aquest lloc");
    expect(own.textOf("there is no signal x/y")).toBe("no hi ha: signal x/y");
    expect(own.textOf("Wind: no value newer than 10 s")).toBe("Wind: cap valor de menys de 10 s");
  });

  test("is said in parts: a problem and its remedy, a name and its reason, a reason within another", () => {
    expect(own.textOf("the name cannot be used; take another")).toBe("el nom no es pot fer servir; tria'n un altre");
    expect(own.textOf("it still moves.")).toBe("encara es mou.");
    expect(own.textOf("Roof: it still moves")).toBe("Roof: encara es mou");
    expect(own.textOf("Dome needs its power: it still moves")).toBe("Dome necessita corrent: encara es mou");
  });

  test("stays as it is where it is not known, or only half of it", () => {
    expect(own.textOf("the robot is on fire")).toBe("the robot is on fire");
    expect(own.textOf("take another; the robot is on fire")).toBe("take another; the robot is on fire");
    expect(own.textOf("")).toBe("");
  });

  test("is left alone in English", () => {
    const answer = { message: "take another" };
    expect(inPageLanguage(answer)).toBe(answer);
    expect(answer.message).toBe("take another");
  });
});

test("no sentence of the hub is taken for another", () => {
  const marked = new HubSentences(SENTENCES.map(([said]) => [said, (...values: readonly string[]) => `${said} ← ${values.join("/")}`]));
  const mistaken = SENTENCES.map(([said]) => [said, marked.textOf(said.replaceAll("{}", "7"))] as const).filter(([said, text]) => !text.startsWith(`${said} ← `));
  expect(mistaken).toEqual([]);
});

test("knows a sentence of several that ends with a point", () => {
  expect(own.textOf("Dome does not close by itself: there is no such site. The guide says how.")).toBe("Dome no es tanca sol: no hi ha aquest lloc. La guia diu com.");
});
