/** Makes modules of catalogues, in the shape that `@lit/localize` reads in its runtime mode. */

import ts from "typescript";
import { FORMS, isMarkup } from "./xliff.mjs";

/**
 * The source of a module with the messages of a catalogue. What is not translated is left out, and stays English.
 *
 * @param units what `readCatalogue` gave
 * @param wanted which messages, by id
 */
export function compileCatalogue(units, wanted = () => true) {
  const entries = units.filter(({ id, target }) => target !== null && wanted(id)).map((unit) => `${JSON.stringify(unit.id)}: ${messageOf(unit)}`);
  return `import { html } from "lit";\nimport { str } from "@lit/localize";\nexport const templates = {\n${entries.join(",\n")}\n};\n`;
}

function messageOf({ id, source, target }) {
  const markup = isMarkup(id);
  const first = numbersOf(source);
  let places = 0;
  const body = target
    .map((part) => {
      if (typeof part === "string") return escapeTemplate(markup ? escapeMarkup(part) : part);
      const known = first.get(part.id);
      if (known === undefined) throw new Error(`${id} has no place {${part.id}}`);
      places += 1;
      const { heads, from } = known;
      return heads.map((head, at) => (at === 0 ? "" : `\${${String(from + at - 1)}}`) + escapeTemplate(head)).join("");
    })
    .join("");
  if (markup) return `html\`${body}\``;
  return places === 0 ? JSON.stringify(target.join("")) : `str\`${body}\``;
}

/** Per place the texts around its expressions, and the number of the first of these in the message. */
function numbersOf(source) {
  const found = new Map();
  let from = 0;
  for (const part of source) {
    if (typeof part === "string") continue;
    const heads = pieces(part.text);
    found.set(part.id, { heads, from });
    from += heads.length - 1;
  }
  return found;
}

function pieces(text) {
  if (!text.includes("${")) return [text];
  const file = ts.createSourceFile("place.ts", `\`${text}\``, ts.ScriptTarget.Latest, false);
  const { expression } = file.statements[0];
  return [expression.head.text, ...expression.templateSpans.map(({ literal }) => literal.text)];
}

function escapeMarkup(text) {
  return text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
}

function escapeTemplate(text) {
  return text.replace(/\\/g, "\\\\").replace(/`/g, "\\`").replace(/\$\{/g, "\\${");
}

export { FORMS };
