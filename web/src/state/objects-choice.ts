/** Which objects, and of which models, a person wants to see on a camera's picture; kept in this browser. */

export interface ObjectsChoice {
  /** Boxes are drawn at all. */
  readonly on: boolean;
  /** What is framed; null for what the site description counts. */
  readonly classes: readonly string[] | null;
  /** What is less sure is not framed, 0 to 1; null as the site description says. */
  readonly confidence: number | null;
}

export const AS_DESCRIBED: ObjectsChoice = { on: true, classes: null, confidence: null };
/** Detectors tell nothing that is less sure. */
export const LEAST_SURE = 0.3;
const MOST_CLASSES = 1000;

type BrowserStorage = Pick<Storage, "getItem" | "setItem" | "removeItem">;

/** @param notes - null where this browser keeps nothing: then the choice holds for this page */
export function readObjects(notes: BrowserStorage | null, person: string, site: string, stream: string): ObjectsChoice {
  let kept: unknown;
  try {
    kept = JSON.parse(notes?.getItem(keyOf(person, site, stream)) ?? "null");
  } catch {
    return AS_DESCRIBED;
  }
  if (typeof kept !== "object" || kept === null) return AS_DESCRIBED;
  const { on, classes, confidence } = kept as Readonly<Record<string, unknown>>;
  return {
    on: on !== false,
    classes: Array.isArray(classes) ? classes.filter((label) => typeof label === "string").slice(0, MOST_CLASSES) : null,
    confidence: typeof confidence === "number" && confidence >= LEAST_SURE && confidence <= 1 ? confidence : null,
  };
}

export function keepObjects(notes: BrowserStorage | null, person: string, site: string, stream: string, choice: ObjectsChoice): void {
  const key = keyOf(person, site, stream);
  try {
    if (choice.on && choice.classes === null && choice.confidence === null) notes?.removeItem(key);
    else notes?.setItem(key, JSON.stringify(choice));
  } catch {
    // Full, or forbidden: it holds for this page.
  }
}

/** By model: whether what it tells is drawn. One that is not in it is as pages show it to everybody. */
export type ShownModels = Readonly<Record<string, boolean>>;

/** @param notes - null where this browser keeps nothing: then the choice holds for this page */
export function readShownModels(notes: BrowserStorage | null, person: string, site: string, stream: string): ShownModels {
  let kept: unknown;
  try {
    kept = JSON.parse(notes?.getItem(keyOf(person, site, stream, "models")) ?? "null");
  } catch {
    return {};
  }
  if (typeof kept !== "object" || kept === null) return {};
  return Object.fromEntries(Object.entries(kept).filter((entry): entry is [string, boolean] => typeof entry[1] === "boolean"));
}

export function keepShownModels(notes: BrowserStorage | null, person: string, site: string, stream: string, shown: ShownModels): void {
  try {
    notes?.setItem(keyOf(person, site, stream, "models"), JSON.stringify(shown));
  } catch {
    // Full, or forbidden: it holds for this page.
  }
}

function keyOf(person: string, site: string, stream: string, what = "objects"): string {
  return `talaia.${what} ${JSON.stringify([person, site, stream])}`;
}
