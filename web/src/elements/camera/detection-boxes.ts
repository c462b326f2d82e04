/** Boxes over a camera's picture, each with what it is and how sure that is. */

import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { objectKind, confidenceText } from "../../format/object-names.js";
import { ElementSizeController } from "../../controllers/element-size.js";
import { styled } from "../base/style-directive.js";
import { isInView, placeOf, labelPlace, type PicturePart, type PixelSize } from "./picture-fit.js";
import { WHOLE, type Zoom } from "./zoom.js";

export interface FramedObject extends PicturePart {
  readonly label: string;
  /** 0 to 1 */
  readonly score: number;
}

/** Lies over the picture and takes nothing from it: presses and screen readers go past. */
@customElement("t-boxes")
export class DetectionBoxes extends LitElement {
  /* A line of its colour between two black ones is seen on any picture; words stand on black. */
  static override styles = css`
    :host {
      display: block;
      position: absolute;
      inset: 0;
      overflow: hidden;
      pointer-events: none;
    }
    .box {
      position: absolute;
      box-sizing: border-box;
      border: 2px solid var(--t-box-thing);
      border-radius: 2px;
      box-shadow:
        0 0 0 1px #000,
        inset 0 0 0 1px #000;
      color: var(--t-box-thing);
    }
    .person {
      border-width: 3px;
      border-color: var(--t-box-person);
      color: var(--t-box-person);
    }
    .animal {
      border-color: var(--t-box-animal);
      color: var(--t-box-animal);
    }
    .vehicle {
      border-color: var(--t-box-vehicle);
      color: var(--t-box-vehicle);
    }
    .plate {
      position: absolute;
      inset-inline-start: 0;
      padding: 0 0.4em;
      border-radius: 3px;
      background: #000;
      font-size: var(--t-size-s);
      font-weight: var(--t-weight-strong);
      line-height: 1.4;
      white-space: nowrap;
      font-variant-numeric: tabular-nums;
    }
    .end .plate {
      inset-inline: auto 0;
    }
    /* Of an earlier picture: it is not where the box is any more. */
    .earlier {
      border-style: dashed;
      border-width: 2px;
      border-color: color-mix(in srgb, currentColor 60%, transparent);
      box-shadow: none;
    }
    .earlier .plate {
      font-weight: var(--t-weight);
    }
  `;

  @property({ attribute: false }) things: readonly FramedObject[] = [];
  /** They were seen on an earlier picture than the one that lies below. */
  @property({ type: Boolean }) earlier = false;
  /** Of the picture (px). */
  @property({ attribute: false }) picture: PixelSize = { width: 4, height: 3 };
  @property({ attribute: false }) zoom: Zoom = WHOLE;

  private readonly view = new ElementSizeController(this);

  override render(): TemplateResult {
    // The surest last: it lies on top.
    return html`<div aria-hidden="true">${map([...this.things].reverse(), (thing) => this.renderBox(thing))}</div>`;
  }

  private renderBox(thing: FramedObject): unknown {
    const place = placeOf(thing, this.view.size, this.picture, this.zoom);
    if (!isInView(place, this.view.size)) return null;
    const where = {
      left: `${place.x.toFixed(1)}px`,
      top: `${place.y.toFixed(1)}px`,
      width: `${place.width.toFixed(1)}px`,
      height: `${place.height.toFixed(1)}px`,
    };
    const end = place.x > this.view.size.width * 0.7 ? "end" : "";
    const plate = labelPlace(place);
    return html`<div
      class="box ${objectKind(thing.label)} ${this.earlier ? "earlier" : ""} ${end}"
      data-label=${thing.label}
      ${styled(where)}
    >
      <span class="plate" ${styled({ top: `${plate.y.toFixed(1)}px`, "margin-left": `${plate.x.toFixed(1)}px` })}>${thing.label} ${confidenceText(thing.score)}</span>
    </div>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-boxes": DetectionBoxes;
  }
}
