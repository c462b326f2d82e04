/** Gives the pages their catalogues: one module for what shows first, one for the rest, for each language. */

import { compileCatalogue, pseudoUnits } from "./compile.mjs";
import { loadedWith, messageIds } from "./messages.mjs";
import { cataloguePath, languages, readCatalogue } from "./xliff.mjs";

const LIST = "virtual:catalogues";
const ONE = "virtual:catalogue/";
/** A language for tests, that is in the build only when asked for: whatever it does not change is in no catalogue. */
const PSEUDO = "en-XA";

/**
 * @param firstPages the files whose messages show first, below `src`
 * @param pseudo whether there is the language of tests, too
 */
export function catalogues({ firstPages, pseudo }) {
  let first = null;
  const isFirst = (id) => (first ??= new Set(loadedWith(firstPages).flatMap(messageIds))).has(id);
  return {
    name: "talaia-catalogues",
    resolveId: (id) => (id === LIST || id.startsWith(ONE) ? `\0${id}` : null),
    load(id) {
      if (id === `\0${LIST}`) return listSource(pseudo ? [...languages(), PSEUDO] : languages());
      if (!id.startsWith(`\0${ONE}`)) return null;
      const [language, part] = id.slice(ONE.length + 1).split("/");
      const from = language === PSEUDO ? languages()[0] : language;
      this.addWatchFile(cataloguePath(from));
      const units = readCatalogue(from);
      return compileCatalogue(language === PSEUDO ? pseudoUnits(units) : units, (message) => isFirst(message) === (part === "first"));
    },
  };
}

function listSource(codes) {
  const parts = (code) => ["first", "rest"].map((part) => `${part}: () => import(${JSON.stringify(`${ONE}${code}/${part}`)})`).join(", ");
  return `export const catalogues = {\n${codes.map((code) => `${JSON.stringify(code)}: { ${parts(code)} }`).join(",\n")}\n};\n`;
}
