/** A form for whatever a JSON schema says, and changes of JSON values by path. Pure. */

import type { Schema } from "../../wire/descriptions-api.js";

export type Json = string | number | boolean | null | readonly Json[] | { readonly [key: string]: Json };
export type JsonObject = Readonly<Record<string, Json>>;
export type JsonPath = readonly string[];

export type FieldKind = "text" | "number" | "whole" | "truth" | "choice" | "words" | "part" | "parts" | "other";

/** One line of a form. */
export interface SchemaField {
  readonly key: string;
  readonly kind: FieldKind;
  readonly label: string;
  /** What the schema says of it. */
  readonly help: string;
  readonly required: boolean;
  /** It may be left out or said to be nothing. */
  readonly nullable: boolean;
  readonly standard: Json;
  /** Of a `choice`: its words. */
  readonly choices: readonly string[];
  /** Of a `part`: its own schema; of `parts`: that of each. */
  readonly schema: Schema;
}

/** What a schema says after its references are followed. */
export function resolveSchema(root: Schema, part: Schema): Schema {
  const reference = part["$ref"];
  if (typeof reference !== "string") return part;
  const name = reference.split("/").at(-1) ?? "";
  const found = (root["$defs"] as Readonly<Record<string, Schema>> | undefined)?.[name];
  return found === undefined ? part : { ...found, ...withoutReference(part) };
}

/** The lines of an object's form, in the order of the schema; what must be said comes first. */
export function schemaFields(root: Schema, part: Schema): SchemaField[] {
  const whole = resolveSchema(root, part);
  const properties = (whole["properties"] ?? {}) as Readonly<Record<string, Schema>>;
  const required = (whole["required"] ?? []) as readonly string[];
  const fields = Object.entries(properties).map(([key, schema]) => fieldOf(root, key, schema, required.includes(key)));
  return [...fields.filter((field) => field.required), ...fields.filter((field) => !field.required)];
}

/** The least that a new part has to say, named after its key. */
export function emptyOf(root: Schema, part: Schema, key: string): JsonObject {
  const made: Record<string, Json> = {};
  for (const field of schemaFields(root, part)) {
    if (!field.required) continue;
    if (field.key === "name") made[field.key] = keyLabel(key);
    else if (field.kind === "part") made[field.key] = emptyOf(root, field.schema, field.key);
    else if (field.kind === "number" || field.kind === "whole") made[field.key] = 1;
    else if (field.kind === "truth") made[field.key] = false;
    else if (field.kind === "words") made[field.key] = [];
    else if (field.kind === "parts") made[field.key] = {};
    else made[field.key] = field.choices[0] ?? "";
  }
  return made;
}

/** `max_rate` as people read it: Max rate. */
export function keyLabel(key: string): string {
  const words = key.replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** A name as a word of an address: small letters, digits and underlines, beginning with a letter. */
export function addressWord(name: string, otherwise: string): string {
  const word = name.toLowerCase().replaceAll(/[^a-z0-9_]+/g, "_").replaceAll(/^[^a-z]+|_+$/g, "");
  return word.slice(0, 60) || otherwise;
}

export function valueAt(value: Json | undefined, path: JsonPath): Json | undefined {
  return path.reduce<Json | undefined>((at, key) => (isObject(at) ? at[key] : undefined), value);
}

/** A copy in which something stands at a path; `undefined` takes it away. */
export function changedAt(value: JsonObject, path: JsonPath, wanted: Json | undefined): JsonObject {
  const [key, ...rest] = path;
  if (key === undefined) return isObject(wanted) ? wanted : value;
  if (rest.length === 0) {
    if (wanted !== undefined) return { ...value, [key]: wanted };
    return Object.fromEntries(Object.entries(value).filter(([name]) => name !== key));
  }
  const inner = value[key];
  return { ...value, [key]: changedAt(isObject(inner) ? inner : {}, rest, wanted) };
}

/**
 * A copy in which a named part has another name, at the same place among the others.
 *
 * A signal says what it was, so that its history goes on under the new name.
 */
export function renamedAt(value: JsonObject, path: JsonPath, name: string): JsonObject {
  const key = path.at(-1);
  const above = valueAt(value, path.slice(0, -1));
  if (key === undefined || !isObject(above) || name === key || name === "" || name in above) return value;
  const entries = Object.entries(above).map(([each, part]): [string, Json] => {
    if (each !== key) return [each, part];
    const signal = path.at(-2) === "signals" && isObject(part) && !part["was"];
    return [name, signal ? { ...part, was: key } : part];
  });
  return changedAt(value, path.slice(0, -1), Object.fromEntries(entries));
}

/** A copy in which a named part stands further up (-1) or down (1) among the others. */
export function movedAt(value: JsonObject, path: JsonPath, by: -1 | 1): JsonObject {
  const key = path.at(-1);
  const above = valueAt(value, path.slice(0, -1));
  if (key === undefined || !isObject(above)) return value;
  const entries = Object.entries(above);
  const from = entries.findIndex(([each]) => each === key);
  const entry = entries[from];
  const other = entries[from + by];
  if (entry === undefined || other === undefined) return value;
  entries[from] = other;
  entries[from + by] = entry;
  return changedAt(value, path.slice(0, -1), Object.fromEntries(entries));
}

/** What a form wants: `set` a value (undefined takes it away), give a part another name or place. */
export type FormEdit =
  | { readonly what: "set"; readonly path: JsonPath; readonly value: Json | undefined }
  | { readonly what: "rename"; readonly path: JsonPath; readonly name: string }
  | { readonly what: "move"; readonly path: JsonPath; readonly by: -1 | 1 };

/** A copy in which an edit is made; the same object where it changes nothing. */
export function applyEdit(value: JsonObject, edit: FormEdit): JsonObject {
  if (edit.what === "set") return changedAt(value, edit.path, edit.value);
  return edit.what === "rename" ? renamedAt(value, edit.path, edit.name) : movedAt(value, edit.path, edit.by);
}

/** The devices that changed parts of a description belong to. */
export function changedDevices(parts: readonly { readonly path: string }[]): string[] {
  const paths = parts.map((part) => pathOf(part.path));
  return [...new Set(paths.flatMap(([first, device]) => (first === "devices" && device !== undefined ? [device] : [])))];
}

/** A name for a new part that none of the others has. */
export function freeName(taken: JsonObject | undefined, wish: string): string {
  if (taken === undefined || !(wish in taken)) return wish;
  let number = 2;
  while (`${wish}${String(number)}` in taken) number += 1;
  return `${wish}${String(number)}`;
}

/** `$.devices.base.name` of a finding as a path. */
export function pathOf(where: string): JsonPath {
  return where.startsWith("$") ? where.slice(1).split(/[.[\]]/).filter((address) => address !== "") : [];
}

export function isObject(value: unknown): value is JsonObject {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function fieldOf(root: Schema, key: string, schema: Schema, required: boolean): SchemaField {
  const choices = alternatives(schema);
  const nullable = choices.some((choice) => choice["type"] === "null");
  const real = choices.filter((choice) => choice["type"] !== "null").map((choice) => resolveSchema(root, choice));
  const inner = mergedShapes(real) ?? resolveSchema(root, schema);
  const help = schema["description"] ?? (inner["properties"] === undefined ? "" : inner["description"]) ?? "";
  return {
    key,
    ...shapeOf(root, inner),
    label: keyLabel(key),
    help: typeof help === "string" ? help : "",
    required,
    nullable,
    standard: (schema["default"] ?? null) as Json,
  };
}

/** What a value may be, however deep a union is nested; one that says by a word what it is stays whole. */
function alternatives(schema: Schema): readonly Schema[] {
  const choices = schema["anyOf"] as readonly Schema[] | undefined;
  return choices === undefined || schema["discriminator"] !== undefined ? [schema] : choices.flatMap(alternatives);
}

/** One shape with the keys of all: a source is one of several protocols, and its connection says of which. */
function mergedShapes(shapes: readonly Schema[]): Schema | undefined {
  const [first] = shapes;
  if (shapes.length < 2) return first;
  if (first === undefined || shapes.some((shape) => shape["properties"] === undefined)) return undefined;
  const required = shapes.map((shape) => (shape["required"] ?? []) as readonly string[]);
  return {
    type: "object",
    properties: Object.assign({}, ...shapes.map((shape) => shape["properties"])) as Schema,
    required: (required[0] ?? []).filter((key) => required.every((keys) => keys.includes(key))),
  };
}

function shapeOf(root: Schema, inner: Schema): Pick<SchemaField, "kind" | "choices" | "schema"> {
  const words = inner["enum"];
  if (Array.isArray(words)) return { kind: "choice", choices: words.map(String), schema: {} };
  const plainField = (kind: FieldKind): Pick<SchemaField, "kind" | "choices" | "schema"> => ({ kind, choices: [], schema: {} });
  switch (inner["type"]) {
    case "string":
      return plainField("text");
    case "number":
      return plainField("number");
    case "integer":
      return plainField("whole");
    case "boolean":
      return plainField("truth");
    case "array":
      return plainField(isWord(resolveSchema(root, (inner["items"] as Schema | undefined) ?? {})) ? "words" : "other");
    case "object": {
      const values = inner["additionalProperties"];
      if (inner["properties"] !== undefined) return { kind: "part", choices: [], schema: inner };
      const part = isObject(values) ? resolveSchema(root, values) : {};
      return part["properties"] === undefined ? plainField("other") : { kind: "parts", choices: [], schema: part };
    }
    default:
      return plainField("other");
  }
}

/** A text, or one of a closed list. */
function isWord(item: Schema): boolean {
  return item["type"] === "string" || Array.isArray(item["enum"]);
}

function withoutReference(part: Schema): Schema {
  return Object.fromEntries(Object.entries(part).filter(([key]) => key !== "$ref"));
}
