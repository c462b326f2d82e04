/** Which messages the pages' code has, read from it without its types. */

import { readdirSync, readFileSync } from "node:fs";
import { dirname, join, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { generateMsgId } from "@lit/localize/internal/id-generation.js";
import ts from "typescript";

export const SOURCES = fileURLToPath(new URL("../src/", import.meta.url));

/** The files of the pages, below `src`. */
export function sourceFiles() {
  return readdirSync(SOURCES, { recursive: true }).filter((name) => name.endsWith(".ts")).sort();
}

/** The ids of the messages in one file. */
export function messageIds(path) {
  const text = readFileSync(join(SOURCES, path), "utf8");
  if (!text.includes("msg(")) return [];
  const found = [];
  const look = (node) => {
    if (ts.isCallExpression(node) && ts.isIdentifier(node.expression) && node.expression.text === "msg") {
      const id = givenId(node.arguments[1]) ?? idOf(node.arguments[0]);
      if (id !== null) found.push(id);
    }
    ts.forEachChild(node, look);
  };
  look(ts.createSourceFile(path, text, ts.ScriptTarget.Latest, true));
  return found;
}

/** The id that the code gives a message, where one text has several meanings: `msg("Open", { id: "open.verb" })`. */
function givenId(options) {
  if (options === undefined || !ts.isObjectLiteralExpression(options)) return null;
  const found = options.properties.find((property) => ts.isPropertyAssignment(property) && property.name.getText() === "id");
  return found !== undefined && ts.isStringLiteral(found.initializer) ? found.initializer.text : null;
}

function idOf(argument) {
  if (argument === undefined) return null;
  if (ts.isStringLiteral(argument) || ts.isNoSubstitutionTemplateLiteral(argument)) return generateMsgId(argument.text, false);
  if (!ts.isTaggedTemplateExpression(argument) || !ts.isIdentifier(argument.tag)) return null;
  const { template } = argument;
  const strings = ts.isNoSubstitutionTemplateLiteral(template) ? [template.text] : [template.head.text, ...template.templateSpans.map(({ literal }) => literal.text)];
  return generateMsgId(strings, argument.tag.text === "html");
}

/** The ids of all messages. */
export function allMessageIds() {
  return new Set(sourceFiles().flatMap(messageIds));
}

const IMPORT = /^(?:import|export)\s+(?!type\b)(?:[^"';]*?\sfrom\s+)?"(\.[^"]+)\.js"/gm;

/** A file and what is loaded with it: all that it imports, but not what it fetches later. */
export function loadedWith(paths) {
  const seen = new Set();
  const visit = (path) => {
    if (seen.has(path)) return;
    seen.add(path);
    const text = readFileSync(join(SOURCES, path), "utf8");
    for (const [, found] of text.matchAll(IMPORT)) visit(relative(SOURCES, resolve(SOURCES, dirname(path), `${found}.ts`)));
  };
  paths.forEach(visit);
  return [...seen].sort();
}
