/** Reads and fills the catalogues of the pages' texts: `locales/CODE.xlf`, XLIFF 1.2 as lit-localize writes it. */

import { readdirSync, readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";

/**
 * A part of a text: words, or a place that is filled in (`id` in the catalogue, `text` as the code has it).
 *
 * @typedef {string | { readonly id: string, readonly text: string }} Part
 * @typedef {{ readonly id: string, readonly source: readonly Part[], readonly target: readonly Part[] | null, readonly note: string }} Unit
 */

export const LOCALES = fileURLToPath(new URL("../locales/", import.meta.url));

/** The codes of the languages there is a catalogue for. */
export function languages() {
  return readdirSync(LOCALES)
    .filter((name) => name.endsWith(".xlf"))
    .map((name) => name.slice(0, -4))
    .sort();
}

export function cataloguePath(language) {
  return `${LOCALES}${language}.xlf`;
}

/** @returns {Unit[]} */
export function readCatalogue(language) {
  return unitsOf(readFileSync(cataloguePath(language), "utf8"));
}

const UNIT = /<trans-unit\b[^>]*\bid="([^"]+)"[^>]*>([\s\S]*?)<\/trans-unit>/g;
const PLACE = /<x\b([^>]*)\/>/g;

/** @returns {Unit[]} */
export function unitsOf(xml) {
  return [...xml.matchAll(UNIT)].map(([, id, body]) => {
    const source = partsOf(insideOf(body, "source") ?? "");
    const target = insideOf(body, "target");
    const note = unescapeXml(insideOf(body, "note") ?? "");
    return { id, source, target: target === null || target.trim() === "" ? null : partsOf(target), note };
  });
}

function insideOf(body, tag) {
  return new RegExp(`<${tag}\\b[^>]*>([\\s\\S]*?)</${tag}>`).exec(body)?.[1] ?? null;
}

/** @returns {Part[]} */
function partsOf(xml) {
  /** @type {Part[]} */
  const parts = [];
  let at = 0;
  for (const match of xml.matchAll(PLACE)) {
    if (match.index > at) parts.push(unescapeXml(xml.slice(at, match.index)));
    const attribute = (name) => unescapeXml(new RegExp(`\\b${name}="([^"]*)"`).exec(match[1])?.[1] ?? "");
    parts.push({ id: attribute("id"), text: attribute("equiv-text") });
    at = match.index + match[0].length;
  }
  if (at < xml.length) parts.push(unescapeXml(xml.slice(at)));
  return parts;
}

const ENTITIES = { lt: "<", gt: ">", quot: '"', apos: "'", amp: "&" };

function unescapeXml(text) {
  return text.replace(/&(?:#x([0-9a-f]+)|#(\d+)|(\w+));/gi, (whole, hex, decimal, name) => {
    if (hex !== undefined) return String.fromCodePoint(parseInt(hex, 16));
    if (decimal !== undefined) return String.fromCodePoint(Number(decimal));
    return ENTITIES[name] ?? whole;
  });
}

function escapeXml(text) {
  return text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
}

/** A text for people who translate: places stand as `{0}`, `{1}`. */
export function plainText(parts) {
  return parts.map((part) => (typeof part === "string" ? part : `{${part.id}}`)).join("");
}

const HASH = /^([hs])[0-9a-f]+$/;

/** Whether a message is markup; one whose id the code gives is not. */
export function isMarkup(id) {
  return HASH.exec(id)?.[1] === "h";
}

/**
 * What is wrong with the id of a message; empty when nothing is.
 *
 * One that the code gives begins with the words it stands for, and then says which meaning it is: changed words
 * are a new message here, too, and never say in another language what they said before.
 */
export function idFault({ id, source }) {
  if (HASH.test(id)) return "";
  const words = plainText(source).replace(/\{\d+\}/g, " ").toLowerCase().match(/[\p{L}\d]+/gu) ?? [];
  const begins = `${words.join("-")}.`;
  return id.startsWith(begins) && /^[a-z][a-z-]*$/.test(id.slice(begins.length)) ? "" : `"${id}" of “${plainText(source)}”: expected "${begins}" and then which meaning it is`;
}

/** What stands at the places of a text, for who wonders what `{0}` is. */
export function placesText(parts) {
  return parts.filter((part) => typeof part !== "string").map(({ id, text }) => `{${id}} = ${text}`).join("; ");
}

/**
 * What is wrong with a translation; empty when nothing is.
 *
 * Each place of the source stands in each of its forms (see `plural`), and no other.
 */
export function faultOf(source, text) {
  if (text.trim() === "") return "it is empty";
  const wanted = placeIds(plainText(source));
  for (const form of text.split(FORMS)) {
    const given = placeIds(form);
    const missing = wanted.filter((id) => !given.includes(id));
    const strange = given.filter((id) => !wanted.includes(id));
    if (missing.length > 0) return `the place {${missing.join("}, {")}} is missing`;
    if (strange.length > 0) return `there is no place {${strange.join("}, {")}}`;
    if (given.length !== wanted.length) return "a place stands there twice";
  }
  return "";
}

/** Between the forms of a text for a language that has more than one and many. */
export const FORMS = "||";

function placeIds(text) {
  return [...text.matchAll(/\{(\d+)\}/g)].map((match) => match[1]).sort();
}

/** The catalogue's XML with translations put in, by message. What they say replaces what was there. */
export function fillCatalogue(xml, translations) {
  return xml.replace(UNIT, (whole, id, body) => {
    const text = translations[id];
    if (text === undefined) return whole;
    const source = partsOf(insideOf(body, "source") ?? "");
    const places = new Map([...(insideOf(body, "source") ?? "").matchAll(PLACE)].map((match, at) => [source.filter((part) => typeof part !== "string")[at].id, match[0]]));
    const target = text.split(/(\{\d+\})/).map((piece) => places.get(/^\{(\d+)\}$/.exec(piece)?.[1]) ?? escapeXml(piece)).join("");
    const without = body.replace(/\s*<target\b[^>]*>[\s\S]*?<\/target>/, "");
    return whole.replace(body, () => without.replace("</source>", () => `</source>\n  <target>${target}</target>`));
  });
}
