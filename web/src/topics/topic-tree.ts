/** A message of a raw topic as the hub gives it, a tree of plain values; see `TopicMessage.tree`. Pure. */

import { msg, str } from "@lit/localize";
import { countedText } from "../format/number.js";
import { plural } from "../words/plural.js";

/** A long array: its first entries, and how many there are. */
interface CutArray {
  readonly $first: readonly unknown[];
  readonly $of: number;
}

/** Long texts: their beginning, and their length (bytes). */
interface CutText {
  readonly $text: string;
  readonly $of: number;
}

export interface TreeChild {
  /** A field's name, or an entry's place: `[3]`. */
  readonly name: string;
  /** As descriptions write it: `pose.position.x`, `shelves[1].celsius`. */
  readonly path: string;
  readonly value: unknown;
}

/** Numbers in a row that are written behind one another. */
const MOST_INLINE = 16;
const MICROS = 1e6;

/** A text whole, or what there is of it. */
export function fullText(value: unknown): string {
  if (typeof value === "string") return value;
  return isCutText(value) ? `${value.$text}…` : "";
}

/** An array's entries, and how many are left out. */
export function listOf(value: unknown): { readonly entries: readonly unknown[]; readonly left: number } {
  if (Array.isArray(value)) return { entries: value as readonly unknown[], left: 0 };
  return isCutArray(value) ? { entries: value.$first, left: value.$of - value.$first.length } : { entries: [], left: 0 };
}

/** The fields or entries of a value that has some to open; null of one that is written in a line. */
export function childrenOf(value: unknown, path: string): readonly TreeChild[] | null {
  if (Array.isArray(value) || isCutArray(value)) {
    const { entries } = listOf(value);
    if (entries.length === 0 || entries.every(isPlain)) return null;
    return entries.map((entry, at) => ({ name: `[${String(at)}]`, path: `${path}[${String(at)}]`, value: entry }));
  }
  if (isPlain(value)) return null;
  const fields = Object.entries(value as Readonly<Record<string, unknown>>);
  if (fields.length === 0) return null;
  return fields.map(([name, field]) => ({ name, path: path === "" ? name : `${path}.${name}`, value: field }));
}

/** A value that is written in a line. */
export function valueText(value: unknown): string {
  if (typeof value === "string") return JSON.stringify(value);
  if (typeof value === "number") return numberText(value);
  if (typeof value === "boolean") return String(value);
  if (isCutText(value)) return `${JSON.stringify(value.$text)}…`;
  if (isOddNumber(value)) return value.$number;
  if (Array.isArray(value) || isCutArray(value)) {
    const { entries, left } = listOf(value);
    const shown = entries.slice(0, MOST_INLINE).map(valueText);
    return `[${shown.join(", ")}${left > 0 || entries.length > shown.length ? ", …" : ""}]`;
  }
  return "{}";
}

/** What is said beside a value: how many entries, or the moment that a stamp means. */
export function valueNote(value: unknown): string {
  if (Array.isArray(value) || isCutArray(value)) {
    const { entries, left } = listOf(value);
    const count = entries.length + left;
    const whole = plural(count, msg(str`${countedText(count)} entry`), msg(str`${countedText(count)} entries`));
    return left > 0 && entries.length > 0 ? msg(str`${whole}, the first ${String(entries.length)} shown`) : whole;
  }
  if (isCutText(value)) return plural(value.$of, msg("1 byte"), msg(str`${countedText(value.$of)} bytes`));
  const us = stampUs(value);
  return us === null ? "" : new Date(us / 1000).toISOString().replace("T", " ").replace("Z", " UTC");
}

/** The moment that ROS's `Time` means (µs since the epoch); null of anything else, and of zero. */
export function stampUs(value: unknown): number | null {
  if (typeof value !== "object" || value === null) return null;
  const { sec, nanosec, ...rest } = value as { sec?: unknown; nanosec?: unknown };
  if (typeof sec !== "number" || typeof nanosec !== "number" || sec <= 0 || Object.keys(rest).length > 0) return null;
  return sec * MICROS + nanosec / 1000;
}

/**
 * The paths to show for a search: what is called so, and what leads there. Null without a search.
 *
 * @param most at the most so many; a robot's map has millions of entries
 */
export function matchingPaths(value: unknown, search: string, most = 500): ReadonlySet<string> | null {
  const words = search.trim().toLowerCase();
  if (words === "") return null;
  const found = new Set<string>();
  const searchChildren = (children: readonly TreeChild[], above: readonly string[]): void => {
    for (const { path, value: inner } of children) {
      if (found.size >= most) return;
      const way = [...above, path];
      if (path.toLowerCase().includes(words)) for (const step of way) found.add(step);
      searchChildren(childrenOf(inner, path) ?? [], way);
    }
  };
  searchChildren(childrenOf(value, "") ?? [], []);
  return found;
}

/** A number with the digits that it has: one that came as a `float32` has fewer. */
export function numberText(value: number): string {
  if (Math.fround(value) !== value || Number.isInteger(value)) return String(value);
  for (let digits = 6; digits < 9; digits++) {
    const short = Number(value.toPrecision(digits));
    if (Math.fround(short) === value) return String(short);
  }
  return String(value);
}

function isPlain(value: unknown): boolean {
  if (typeof value !== "object" || value === null) return true;
  return isOddNumber(value) || isCutText(value);
}

function isCutArray(value: unknown): value is CutArray {
  return typeof value === "object" && value !== null && "$first" in value;
}

function isCutText(value: unknown): value is CutText {
  return typeof value === "object" && value !== null && "$text" in value;
}

function isOddNumber(value: unknown): value is { readonly $number: string } {
  return typeof value === "object" && value !== null && "$number" in value;
}
