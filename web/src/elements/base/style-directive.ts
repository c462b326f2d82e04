/** Styles from values: `styleMap` writes an attribute at first, which the hub's content policy forbids. */

import { noChange } from "lit";
import { directive, Directive, PartType, type ElementPart, type PartInfo } from "lit/directive.js";

type Styles = Readonly<Record<string, string>>;

class StyleDirective extends Directive {
  private set: readonly string[] = [];

  constructor(part: PartInfo) {
    super(part);
    if (part.type !== PartType.ELEMENT) throw new Error("styled() stands in a tag, not in an attribute");
  }

  /** Notes what is set, so that it can be taken away again. */
  render(styles: Styles): unknown {
    this.set = Object.keys(styles);
    return noChange;
  }

  override update({ element }: ElementPart, [styles]: [Styles]): unknown {
    if (!(element instanceof HTMLElement || element instanceof SVGElement)) return noChange;
    for (const name of this.set) if (!(name in styles)) element.style.removeProperty(name);
    for (const [name, value] of Object.entries(styles)) element.style.setProperty(name, value);
    return this.render(styles);
  }
}

/** Sets style properties of the element in whose tag it stands: `<p ${styled({ left: "4px" })}>`. */
export const styled = directive(StyleDirective);
