/** Reads numbers of a form and keeps what is wrong with each, by its field. Pure. */

import { msg, str } from "@lit/localize";
import { roundText } from "../../../format/number.js";

export type NumberRange = readonly [low: number, high: number];

export class FieldReader<Field extends string> {
  readonly problems = new Map<Field, string>();

  /** @param what it is, with its unit: `Exposure in s` */
  number(field: Field, text: string, [low, high]: NumberRange, what: string): number {
    const value = text.trim() === "" ? Number.NaN : Number(text.trim().replace(/[−–]/, "-").replace(",", "."));
    if (!(value >= low && value <= high)) this.problems.set(field, msg(str`${what}: expected ${roundText(low, 9)} to ${roundText(high, 9)}.`));
    return value;
  }

  /** `without` where nothing is written. */
  optional<Without>(field: Field, text: string, range: NumberRange, what: string, without: Without): number | Without {
    return text.trim() === "" ? without : this.number(field, text, range, what);
  }

  whole(field: Field, text: string, range: NumberRange, what: string): number {
    const value = this.number(field, text, range, what);
    if (Number.isFinite(value) && !Number.isInteger(value)) this.problems.set(field, msg(str`${what}: expected a whole number.`));
    return value;
  }
}
