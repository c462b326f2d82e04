import { readFileSync } from "node:fs";
import { describe, expect, test } from "vitest";
import { compileCatalogue } from "../../catalogue/compile.mjs";
import { allMessageIds } from "../../catalogue/messages.mjs";
import { isSentence, plainTexts } from "../../catalogue/plain-text-rule.mjs";
import { pseudoModule, pseudoUnits } from "../../catalogue/pseudo.mjs";
import { faultOf, fillCatalogue, idFault, languages, plainText, readCatalogue, unitsOf } from "../../catalogue/xliff.mjs";

/** How many texts of a language may be English still: only ever lowered. */
const pending = JSON.parse(readFileSync(new URL("../../locales/pending.json", import.meta.url), "utf8")) as Readonly<Record<string, number>>;

const written = allMessageIds();

describe.each(languages())("the catalogue of %s", (language) => {
  const units = readCatalogue(language);

  test("has the texts of the code and no other: else run `python tools/node.py run extract`", () => {
    const there = new Set(units.map(({ id }) => id));
    expect([...written].filter((id) => !there.has(id))).toEqual([]);
    expect([...there].filter((id) => !written.has(id))).toEqual([]);
  });

  test("has no more texts in English than are written in pending.json", () => {
    expect(units.filter(({ target }) => target === null).length).toBeLessThanOrEqual(pending[language] ?? Infinity);
  });

  test("has ids of the code that begin with their words and say which meaning it is", () => {
    expect(units.map(idFault).filter((fault) => fault !== "")).toEqual([]);
  });

  test("has each place of a text in its translation", () => {
    const faults = units.flatMap(({ id, source, target }) => (target === null ? [] : [[id, faultOf(source, plainText(target))]])).filter(([, fault]) => fault !== "");
    expect(faults).toEqual([]);
  });
});

const XLIFF = `<trans-unit id="s1">
  <source><x id="0" equiv-text="\${String(count)}"/> of <x id="1" equiv-text="\${all}"/> &amp; more</source>
</trans-unit>
<trans-unit id="h2">
  <source>Open <x id="0" equiv-text="&lt;a href=&quot;\${path}&quot;&gt;"/>the page<x id="1" equiv-text="&lt;/a&gt;"/></source>
  <target>old</target>
</trans-unit>`;

describe("a catalogue", () => {
  test("takes translations, with their places in another order", () => {
    const [first, second] = unitsOf(fillCatalogue(XLIFF, { s1: "de {1}, {0} & més", h2: "{0}La pàgina{1}, obre-la" }));
    expect(plainText(first?.target ?? [])).toBe("de {1}, {0} & més");
    expect(plainText(second?.target ?? [])).toBe("{0}La pàgina{1}, obre-la");
    const made = compileCatalogue([first, second]);
    expect(made).toContain('"s1": str`de ${1}, ${0} & més`');
    expect(made).toContain('"h2": html`<a href="${0}">La pàgina</a>, obre-la`');
  });

  test("refuses a place that is missing, strange or twice, in each form", () => {
    const source = unitsOf(XLIFF)[0]?.source;
    expect(faultOf(source, "{0} de {1}")).toBe("");
    expect(faultOf(source, "{0} de {1}||{1} de {0}")).toBe("");
    expect(faultOf(source, "{0} de {1}||{1}")).toContain("{0} is missing");
    expect(faultOf(source, "{0} de {1} {2}")).toContain("no place {2}");
    expect(faultOf(source, "{0} {0} de {1}")).toContain("twice");
    expect(faultOf(source, " ")).toContain("empty");
  });

  test("makes no markup of what a translation says", () => {
    const [unit] = unitsOf(fillCatalogue(XLIFF, { h2: "{0}<script>`${x}{1}" })).slice(1);
    expect(compileCatalogue([unit])).toContain("&lt;script&gt;\\`\\${x}");
  });

  test("has a language for tests that changes and lengthens every text", () => {
    expect(compileCatalogue(pseudoUnits(unitsOf(XLIFF)))).toContain("⟦${0} óf ${1} & móré ééé⟧");
    const long = plainText(pseudoUnits(unitsOf(XLIFF))[1]?.target ?? []);
    expect(long.length).toBeGreaterThanOrEqual(1.3 * "Open {0}the page{1}".length);
    expect(pseudoModule()).not.toContain("import ");
  });

  test("has no words in the build that no language has", () => {
    expect(languages()).not.toContain("en-XA");
    expect(readFileSync(new URL("../../catalogue/plugin.mjs", import.meta.url), "utf8")).not.toContain("pseudo");
  });
});

test("a message whose id the code gives is told from others of the same words, and changed words ask for another id", () => {
  const unit = { id: "open.verb", source: ["Open"], target: null, note: "" };
  expect(idFault(unit)).toBe("");
  expect(idFault({ ...unit, source: ["Open it"] })).toContain('expected "open-it."');
  expect(idFault({ ...unit, id: "open" })).toContain("which meaning");
  expect(idFault({ ...unit, id: "saf64034c86022ed1" })).toBe("");
});

describe("the rule against bare texts", () => {
  test("finds texts and attributes that are read", () => {
    expect(plainTexts(['<p title="Some words">', " <b>not known</b></p>"])).toEqual(['title="Some words"', "not known"]);
  });

  test("finds sentences in code, and no names, paths or selectors", () => {
    expect(["Write a date and a time.", "This site takes no  0  frames for requests."].map(isSentence)).toEqual([true, true]);
    expect(["Windows", "stop key", "Content-Type", "M2 2h12v8H8.5L5 14v-4H2z", "transform: translate"].map(isSentence)).toEqual([false, false, false, false, false]);
  });

  test("lets code, units, names and what is filled in pass", () => {
    expect(plainTexts(["<code>talaia hub</code> <b class='very wide'>", " kB</b> STOP <img alt=", "> 5 %"])).toEqual([]);
  });
});
