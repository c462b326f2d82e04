/** What a person filled in as a command's arguments: checked, and put into their types. */

import type { ArgumentShape } from "../../generated/api.js";
import { formatNumber } from "../../format/number.js";

export type ArgumentValue = number | boolean | string;

export type CheckedArgument =
  | { readonly ok: true; readonly value: ArgumentValue }
  | { readonly ok: false; readonly why: string };

/** @param text - as typed; of a boolean: "true" or "false" */
export function checkArgument(argument: ArgumentShape, text: string): CheckedArgument {
  switch (argument.type) {
    case "boolean":
      return { ok: true, value: text === "true" };
    case "text":
      if (text.length <= argument.max_length) return { ok: true, value: text };
      return { ok: false, why: `At most ${String(argument.max_length)} characters; these are ${String(text.length)}.` };
    case "number":
    case "integer":
      return checkNumber(argument, text.trim().replace(",", "."));
  }
}

function checkNumber(argument: ArgumentShape, text: string): CheckedArgument {
  const value = Number(text);
  if (text === "" || !Number.isFinite(value)) return { ok: false, why: "A number is needed here." };
  if (argument.type === "integer" && !Number.isInteger(value)) {
    return { ok: false, why: "A whole number is needed here." };
  }
  const { minimum, maximum } = argument;
  if ((minimum !== null && value < minimum) || (maximum !== null && value > maximum)) {
    return { ok: false, why: `It may be ${argumentLimitText(argument)}.` };
  }
  return { ok: true, value };
}

/** `0 to 360 °`, `0 or more`; empty without limits. */
export function argumentLimitText({ minimum, maximum, unit }: ArgumentShape): string {
  const numberText = (value: number): string => formatNumber(value, Number.isInteger(value) ? 0 : 3).replace(/(\.\d*?)0+$/, "$1");
  const tail = unit === "" ? "" : `\u202f${unit}`;
  if (minimum !== null && maximum !== null) return `${numberText(minimum)} to ${numberText(maximum)}${tail}`;
  if (minimum !== null) return `${numberText(minimum)}${tail} or more`;
  return maximum === null ? "" : `${numberText(maximum)}${tail} or less`;
}

/** What a field starts with. */
export function initialText(argument: ArgumentShape): string {
  if (argument.default !== null) return String(argument.default);
  return argument.type === "boolean" ? "false" : "";
}
