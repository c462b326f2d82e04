/** Gives the pages their catalogues: one module for what shows first, one for the rest, for each language. */

import { compileCatalogue } from "./compile.mjs";
import { loadedWith, messageIds } from "./messages.mjs";
import { cataloguePath, languages, readCatalogue } from "./xliff.mjs";

const LIST = "virtual:catalogues";
const ONE = "virtual:catalogue/";

/** @param firstPages the files whose messages show first, below `src` */
export function catalogues({ firstPages }) {
  let first = null;
  const isFirst = (id) => (first ??= new Set(loadedWith(firstPages).flatMap(messageIds))).has(id);
  return {
    name: "talaia-catalogues",
    resolveId: (id) => (id === LIST || id.startsWith(ONE) ? `\0${id}` : null),
    load(id) {
      if (id === `\0${LIST}`) return listSource(languages());
      if (!id.startsWith(`\0${ONE}`)) return null;
      const [language, part] = id.slice(ONE.length + 1).split("/");
      this.addWatchFile(cataloguePath(language));
      return compileCatalogue(readCatalogue(language), (message) => isFirst(message) === (part === "first"));
    },
  };
}

function listSource(codes) {
  const parts = (code) => ["first", "rest"].map((part) => `${part}: () => import(${JSON.stringify(`${ONE}${code}/${part}`)})`).join(", ");
  return `export const catalogues = {\n${codes.map((code) => `${JSON.stringify(code)}: { ${parts(code)} }`).join(",\n")}\n};\n`;
}
