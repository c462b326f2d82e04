/** What hub and gateways say in English, in the page's language as far as its catalogue has it. */

import { intlLocale } from "./locale.js";

/** A sentence with `{}` for what is filled in, and how pages say it. */
type Sentence = readonly [said: string, text: (...values: readonly string[]) => string];

/** Fields of answers and messages in which hub and gateways speak to people. */
const SPOKEN: ReadonlySet<string> = new Set(["link_loss", "message", "no_override", "problem", "reason", "remedy", "step", "unknown_why", "why", "why_not"]);
/** A sentence within another that stands in a third: nothing says more at once. */
const DEEPEST = 3;
/** What is longer is no sentence, but a file or a list. */
const LONGEST = 1000;

interface Pattern {
  readonly matcher: RegExp;
  readonly text: Sentence[1];
}

/** A sentence is looked for without the point at its end, and given one again. */
function withoutStop(sentence: Sentence): Sentence {
  const [said, text] = sentence;
  return said.endsWith(".") ? [said.slice(0, -1), (...values) => text(...values).replace(/\.$/, "")] : sentence;
}

/** Recognises sentences by their templates. */
export class HubSentences {
  private readonly plain = new Map<string, Sentence[1]>();
  /** The most words first: what says more is no case of what says less. */
  private readonly patterns: readonly Pattern[];

  constructor(sentences: readonly Sentence[]) {
    const filled = sentences.filter(([said]) => said.includes("{}")).map(withoutStop);
    for (const [said, text] of sentences) if (!said.includes("{}")) this.plain.set(said, text);
    this.patterns = [...filled].sort(([a], [b]) => b.length - a.length).map(([said, text]) => ({ matcher: matcherOf(said), text }));
  }

  /** The same in the page's language; as it was where it is not known. */
  textOf(said: string, depth = 0): string {
    if (said.length > LONGEST) return said;
    // Some end as sentences do, most as pages want them.
    if (said.endsWith(".") && !this.plain.has(said)) return `${this.textOf(said.slice(0, -1), depth)}.`;
    return this.wholeText(said, depth) ?? this.partsText(said, depth) ?? said;
  }

  private wholeText(said: string, depth: number): string | null {
    const plain = this.plain.get(said);
    if (plain !== undefined) return plain();
    if (depth >= DEEPEST) return null;
    for (const { matcher, text } of this.patterns) {
      const found = matcher.exec(said);
      if (found !== null) return text(...found.slice(1).map((value) => this.valueText(value, depth + 1)));
    }
    return null;
  }

  /** A name and what is said of it, or a problem and what to do about it; all of it, or nothing. */
  private partsText(said: string, depth: number): string | null {
    const remedies = said.split("; ");
    if (remedies.length > 1) {
      const texts = remedies.map((part) => this.wholeText(part, depth));
      return texts.every((text) => text !== null) ? texts.join("; ") : null;
    }
    const at = said.indexOf(": ");
    if (at < 0 || depth >= DEEPEST) return null;
    const rest = said.slice(at + 2);
    const text = this.textOf(rest, depth + 1);
    return text === rest ? null : `${said.slice(0, at)}: ${text}`;
  }

  private valueText(value: string, depth: number): string {
    return /^-?\d+\.\d+( \S+)?$/.test(value) ? value.replace(".", decimalMark()) : this.textOf(value, depth);
  }
}

function matcherOf(said: string): RegExp {
  const parts = said.split("{}").map((part) => part.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"));
  return new RegExp(`^${parts.join("(.+?)")}$`, "s");
}

function decimalMark(): string {
  return new Intl.NumberFormat(intlLocale()).formatToParts(1.5).find(({ type }) => type === "decimal")?.value ?? ".";
}

let known: HubSentences | null = null;

/** Called once, when the page is in another language than the code. */
export function learnSentences(sentences: readonly Sentence[]): void {
  known = new HubSentences(sentences);
}

/** What the hub said, in the page's language as far as it is known there. */
export function hubText(said: string): string {
  return known === null || said === "" ? said : known.textOf(said);
}

/** An answer or a message of the hub, with what it says to people in the page's language; the same thing, changed. */
export function inPageLanguage<T>(answer: T): T {
  if (known !== null) translateWithin(answer);
  return answer;
}

function translateWithin(value: unknown): void {
  // Columns of numbers are long, and say nothing.
  if (typeof value !== "object" || value === null || ArrayBuffer.isView(value) || (Array.isArray(value) && typeof value[0] !== "object")) return;
  const fields = value as Record<string, unknown>;
  for (const [field, inside] of Object.entries(fields)) {
    if (typeof inside === "object") translateWithin(inside);
    else if (typeof inside === "string" && SPOKEN.has(field)) fields[field] = hubText(inside);
  }
}
