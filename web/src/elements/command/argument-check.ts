/** What a person filled in as a command's arguments: checked, and put into their types. */

import { msg, str } from "@lit/localize";
import type { ArgumentShape } from "../../generated/api.js";
import { formatNumber } from "../../format/number.js";

export type ArgumentValue = number | boolean | string;

export type CheckedArgument =
  | { readonly ok: true; readonly value: ArgumentValue }
  | { readonly ok: false; readonly why: string };

const TRUTHS: Readonly<Record<string, boolean>> = { true: true, on: true, false: false, off: false };

const HINTS: Partial<Record<ArgumentShape["type"], string>> = {
  numbers: msg("With commas between: 0.5, 2"),
  integers: msg("With commas between: 1, 2"),
  bytes: msg("With commas between: 1, 2"),
  booleans: msg("With commas between: true, false"),
  texts: msg("With commas between: a, b; texts with commas as [\"a, b\", \"c\"]"),
};

/** How a list is written; empty where the argument is none. */
export function listHint(argument: ArgumentShape): string {
  return HINTS[argument.type] ?? "";
}

/** @param text - as typed; of a boolean: "true" or "false" */
export function checkArgument(argument: ArgumentShape, text: string): CheckedArgument {
  switch (argument.type) {
    case "boolean":
      return { ok: true, value: text === "true" };
    case "text":
      if (text.length <= argument.max_length) return { ok: true, value: text };
      return { ok: false, why: msg(str`At most ${String(argument.max_length)} characters; these are ${String(text.length)}.`) };
    case "number":
    case "integer":
      return checkNumber(argument, text.trim().replace(",", "."));
    case "numbers":
    case "integers":
    case "booleans":
    case "texts":
    case "bytes":
      return checkList(argument, text.trim());
  }
}

/** Items of a list as one text: `[1, 2.5]`, or `1, 2.5`; null where it begins with [ and is no JSON list. */
function itemsOf(argument: ArgumentShape, text: string): readonly unknown[] | null {
  if (text === "") return [];
  if (!text.startsWith("[")) {
    const words = text.split(",").map((word) => word.trim());
    return argument.type === "texts" ? words : words.map(wordValue);
  }
  try {
    return JSON.parse(text) as unknown[];
  } catch {
    return null;
  }
}

function wordValue(word: string): unknown {
  const truth = TRUTHS[word.toLowerCase()];
  if (truth !== undefined) return truth;
  return word === "" ? word : Number(word);
}

function checkList(argument: ArgumentShape, text: string): CheckedArgument {
  if (text.length > argument.max_length) {
    return { ok: false, why: msg(str`At most ${String(argument.max_length)} characters; these are ${String(text.length)}.`) };
  }
  const items = itemsOf(argument, text);
  if (items === null) return { ok: false, why: msg("It begins with [ but is no JSON list.") };
  const wrong = items.findIndex((item) => !isItem(argument, item));
  // As it was typed: numbers of JavaScript hold no integer of 64 bits.
  if (wrong < 0) return { ok: true, value: text };
  return { ok: false, why: msg(str`Item ${String(wrong + 1)}: ${itemText(argument)} is needed.`) };
}

function isItem(argument: ArgumentShape, item: unknown): boolean {
  if (argument.type === "booleans") return typeof item === "boolean";
  if (argument.type === "texts") return typeof item === "string";
  if (typeof item !== "number" || !Number.isFinite(item)) return false;
  if (argument.type !== "numbers" && !Number.isInteger(item)) return false;
  if (argument.type === "bytes" && (item < 0 || item > 255)) return false;
  return item >= (argument.minimum ?? -Infinity) && item <= (argument.maximum ?? Infinity);
}

function itemText(argument: ArgumentShape): string {
  if (argument.type === "booleans") return msg("true or false");
  if (argument.type === "texts") return msg("a text");
  const what = argument.type === "numbers" ? msg("a number") : msg("a whole number");
  if (argument.type === "bytes") return msg(str`${what} from 0 to 255`);
  const limits = argumentLimitText(argument);
  return limits === "" ? what : `${what}, ${limits},`;
}

function checkNumber(argument: ArgumentShape, text: string): CheckedArgument {
  const value = Number(text);
  if (text === "" || !Number.isFinite(value)) return { ok: false, why: msg("A number is needed here.") };
  if (argument.type === "integer" && !Number.isInteger(value)) {
    return { ok: false, why: msg("A whole number is needed here.") };
  }
  const { minimum, maximum } = argument;
  if ((minimum !== null && value < minimum) || (maximum !== null && value > maximum)) {
    return { ok: false, why: msg(str`It may be ${argumentLimitText(argument)}.`) };
  }
  return { ok: true, value };
}

/** `0 to 360 °`, `0 or more`; empty without limits. */
export function argumentLimitText({ minimum, maximum, unit }: ArgumentShape): string {
  const numberText = (value: number): string => formatNumber(value, Number.isInteger(value) ? 0 : 3).replace(/(\.\d*?)0+$/, "$1");
  const tail = unit === "" ? "" : `\u202f${unit}`;
  if (minimum !== null && maximum !== null) return msg(str`${numberText(minimum)} to ${numberText(maximum)}${tail}`);
  if (minimum !== null) return msg(str`${numberText(minimum)}${tail} or more`);
  return maximum === null ? "" : msg(str`${numberText(maximum)}${tail} or less`);
}

/** What a field starts with. */
export function initialText(argument: ArgumentShape): string {
  if (argument.default !== null) return String(argument.default);
  return argument.type === "boolean" ? "false" : "";
}
