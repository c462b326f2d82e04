/**
 * For who translates the pages; see docs/how-to/extend/add-a-language.md.
 *
 *     node catalogue/cli.mjs add fr            begin a language
 *     node catalogue/cli.mjs dump ca           what is not translated yet, as JSON on standard output
 *     node catalogue/cli.mjs fill ca FILE      take translations from such a file: {id: text}
 *     node catalogue/cli.mjs count             how much of each language is there
 */

import { readFileSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { cataloguePath, faultOf, fillCatalogue, languages, placesText, plainText, readCatalogue } from "./xliff.mjs";

const SETTINGS = fileURLToPath(new URL("../lit-localize.json", import.meta.url));

const [verb = "", language = "", file = ""] = process.argv.slice(2);

const verbs = {
  add() {
    if (!/^[a-z]{2,3}(-[A-Za-z0-9]+)*$/.test(language)) return fail(`"${language}" is no code of a language. Expected one such as fr, pt-BR or zh-Hant.`);
    const settings = JSON.parse(readFileSync(SETTINGS, "utf8"));
    settings.targetLocales = [...new Set([...settings.targetLocales, language])].sort();
    writeFileSync(SETTINGS, `${JSON.stringify(settings, null, 2)}\n`);
    console.log(`${language} is in lit-localize.json. Now run: python tools/node.py run extract`);
    return 0;
  },
  dump() {
    const open = units().filter(({ target }) => target === null);
    const found = open.map(({ id, source, note }) => [id, { source: plainText(source), note: [note, placesText(source)].filter(Boolean).join("; ") }]);
    console.log(JSON.stringify(Object.fromEntries(found), null, 1));
    return 0;
  },
  fill() {
    const given = JSON.parse(readFileSync(file, "utf8"));
    const known = new Map(units().map((unit) => [unit.id, unit]));
    const faults = Object.entries(given).flatMap(([id, text]) => {
      const unit = known.get(id);
      const fault = unit === undefined ? "there is no such message" : typeof text !== "string" ? "expected a text" : faultOf(unit.source, text);
      return fault === "" ? [] : [`${file}: ${id}: ${fault}${unit === undefined ? "" : ` (“${plainText(unit.source)}” → “${String(text)}”)`}`];
    });
    if (faults.length > 0) return fail(`${faults.join("\n")}\nNothing was taken: mend these and try again.`);
    writeFileSync(cataloguePath(language), fillCatalogue(readFileSync(cataloguePath(language), "utf8"), given));
    console.log(`${String(Object.keys(given).length)} texts are in ${language}.xlf.`);
    return 0;
  },
  count() {
    for (const code of languages()) {
      const all = readCatalogue(code);
      console.log(`${code}: ${String(all.filter(({ target }) => target !== null).length)} of ${String(all.length)} texts`);
    }
    return 0;
  },
};

function units() {
  return readCatalogue(language);
}

function fail(why) {
  console.error(why);
  return 1;
}

const run = verbs[verb];
if (run === undefined) process.exitCode = fail("Expected one of: add CODE, dump CODE, fill CODE FILE, count.");
else if ((verb === "dump" || verb === "fill") && !languages().includes(language)) process.exitCode = fail(`There is no catalogue of "${language}". There are: ${languages().join(", ")}.`);
else process.exitCode = run();
