/** Which of the things on a picture are framed and counted for this person. Pure. */

import type { ObjectCount } from "../../elements/camera/objects-overlay.js";
import type { ObjectOption } from "../../elements/camera/objects-choice.js";
import type { DetectedObject } from "../../generated/wire.js";
import { LEAST_SURE, type ObjectsChoice } from "../../state/objects-choice.js";
import type { DetectShape } from "../../generated/api.js";

/** How sure it must be, 0 to 1. */
export function minimumConfidence(choice: ObjectsChoice, detects: DetectShape): number {
  return Math.max(LEAST_SURE, choice.confidence ?? detects.confidence);
}

export function framedObjects(things: readonly DetectedObject[], choice: ObjectsChoice, detects: DetectShape): readonly DetectedObject[] {
  const classes = new Set(choice.classes ?? detects.classes);
  const sure = minimumConfidence(choice, detects);
  return things.filter(({ label, score }) => classes.has(label) && score >= sure);
}

/** How many of each, the most first. */
export function countObjects(things: readonly DetectedObject[]): readonly ObjectCount[] {
  const many = new Map<string, number>();
  for (const { label } of things) many.set(label, (many.get(label) ?? 0) + 1);
  return [...many]
    .map(([label, one]) => ({ label, many: one }))
    .sort((a, b) => b.many - a.many || a.label.localeCompare(b.label));
}

/** Those of the description in its order, then what was chosen or seen, by name. */
export function objectOptions(detects: DetectShape, seen: ReadonlySet<string>, choice: ObjectsChoice): readonly ObjectOption[] {
  const wanted = new Set(choice.classes ?? detects.classes);
  const others = [...new Set([...(choice.classes ?? []), ...seen])].filter((label) => !detects.classes.includes(label));
  return [
    ...detects.classes.map((label) => ({ label, wanted: wanted.has(label), described: true })),
    ...others.sort((a, b) => a.localeCompare(b)).map((label) => ({ label, wanted: wanted.has(label), described: false })),
  ];
}
