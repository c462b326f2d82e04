/** The value of a field that somebody may be typing in: as long as they are in it, it is theirs. */

import { noChange } from "lit";
import { directive, Directive, PartType, type PartInfo, type PropertyPart } from "lit/directive.js";
import { setCommittedValue } from "lit/directive-helpers.js";

class StableField extends Directive {
  constructor(part: PartInfo) {
    super(part);
    if (part.type !== PartType.PROPERTY || part.name !== "value") throw new Error("settled() is for .value");
  }

  render(value: string): string {
    return value;
  }

  override update(part: PropertyPart, [value]: [string]): unknown {
    const { element } = part;
    if (!(element instanceof HTMLInputElement) || element.matches(":focus") || element.value === value) return noChange;
    // Set also when it was set before: meanwhile somebody may have typed.
    setCommittedValue(part);
    return value;
  }
}

/** `.value=${settled(text)}` takes no blank away that is typed before the next word. */
export const settled = directive(StableField);
