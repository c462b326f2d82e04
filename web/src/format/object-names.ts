/** What a camera sees, in words: classes by name, how many, and how sure. */

import { msg, str } from "@lit/localize";
import { formatDuration } from "./duration.js";
import { fixedText } from "./number.js";

/** What a class means to who looks: it has a colour of its own, and always its name beside. */
export type ObjectKind = "person" | "animal" | "vehicle" | "thing";

const ANIMALS: ReadonlySet<string> = new Set([
  "bird", "cat", "dog", "horse", "sheep", "cow", "elephant", "bear", "zebra", "giraffe", "animal", "deer", "fox",
]);
const VEHICLES: ReadonlySet<string> = new Set([
  "bicycle", "car", "motorcycle", "motorbike", "airplane", "aeroplane", "bus", "train", "truck", "boat", "van", "tractor",
  "vehicle", "forklift",
]);
const PERSONS: ReadonlySet<string> = new Set(["person", "people", "pedestrian", "human", "man", "woman", "child"]);

const PLURALS: Readonly<Record<string, string>> = {
  person: "persons", sheep: "sheep", deer: "deer", mouse: "mice", knife: "knives", man: "men", woman: "women", child: "children",
  people: "people", scissors: "scissors", skis: "skis", aircraft: "aircraft",
};

/** What a class is, so far as its name tells. */
export function objectKind(label: string): ObjectKind {
  const word = label.toLowerCase();
  if (PERSONS.has(word)) return "person";
  if (ANIMALS.has(word)) return "animal";
  return VEHICLES.has(word) ? "vehicle" : "thing";
}

/** `1 person`, `2 persons`, `3 wine glasses`. */
export function countText(many: number, label: string): string {
  return `${String(many)} ${many === 1 ? label : pluralOf(label)}`;
}

function pluralOf(label: string): string {
  const last = label.split(" ").at(-1) ?? label;
  const rest = label.slice(0, label.length - last.length);
  const own = PLURALS[last];
  if (own !== undefined) return rest + own;
  if (/(s|x|z|ch|sh)$/.test(last)) return `${label}es`;
  if (/[^aeiou]y$/.test(last)) return `${label.slice(0, -1)}ies`;
  return `${label}s`;
}

/** What one thing did while it was in sight. */
export interface SightingStory {
  /** Where it stood, by parts of the picture's width and height from the upper left. */
  readonly path?: readonly { readonly x: number; readonly y: number }[];
  readonly stays: readonly { readonly zone: string; readonly entries: number; readonly dwell_s: number }[];
  readonly crossings: readonly { readonly line: string; readonly left: number; readonly right: number }[];
  /** Mean on the floor (m/s); null where that is not known. */
  readonly speed: number | null;
}

/** `12 s in Mat`, `crossed Door to the left twice`, `1.2 m/s`. */
export function storyFacts(story: SightingStory | null | undefined): string[] {
  if (story === null || story === undefined) return [];
  const facts = story.stays.map(({ zone, entries, dwell_s }) =>
    entries > 1 ? msg(str`${formatDuration(dwell_s)} in ${zone}, came ${timesText(entries)}`) : msg(str`${formatDuration(dwell_s)} in ${zone}`));
  for (const { line, left, right } of story.crossings) {
    if (left > 0) facts.push(left === 1 ? msg(str`crossed ${line} to the left`) : msg(str`crossed ${line} to the left ${timesText(left)}`));
    if (right > 0) facts.push(right === 1 ? msg(str`crossed ${line} to the right`) : msg(str`crossed ${line} to the right ${timesText(right)}`));
  }
  if (story.speed !== null) facts.push(`${fixedText(story.speed, 1)}\u202fm/s`);
  return facts;
}

function timesText(many: number): string {
  return many === 2 ? msg("twice") : msg(str`${String(many)} times`);
}

/** `87 %`, with a space that no line is broken at. */
export function confidenceText(part: number): string {
  return `${String(Math.round(part * 100))}\u00a0%`;
}
