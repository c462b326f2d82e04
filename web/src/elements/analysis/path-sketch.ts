/**
 * The way that a thing took over a camera's picture, small. Its thumbnail is cut out around the
 * thing, and so its path cannot lie on that: the frame here is all of the picture.
 */

import { msg } from "@lit/localize";
import { css, html, LitElement, svg, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { arrowHead, pointsText } from "../camera/mark-shapes.js";

const WIDTH = 80;
const HEIGHT = 60;

@customElement("t-path-sketch")
export class PathSketch extends LitElement {
  static override styles = css`
    :host {
      display: block;
      inline-size: 5rem;
    }
    svg {
      display: block;
      inline-size: 100%;
      block-size: auto;
      border: 1px solid var(--t-line);
      border-radius: var(--t-radius-s);
      background: var(--t-raised);
    }
    polyline {
      fill: none;
      stroke: var(--t-text);
      stroke-width: 2;
      stroke-linecap: round;
      stroke-linejoin: round;
    }
    circle {
      fill: var(--t-text);
    }
  `;

  /** By parts of the picture's width and height from the upper left, the first first. */
  @property({ attribute: false }) path: readonly { readonly x: number; readonly y: number }[] = [];

  override render(): TemplateResult {
    const points = this.path.map(({ x, y }) => ({ x: x * WIDTH, y: y * HEIGHT }));
    const [first] = points;
    return html`<svg viewBox="0 0 ${WIDTH} ${HEIGHT}" role="img" aria-label=${msg("Path over the camera’s picture")}>
      <title>${msg("Path over the camera’s picture, from the dot to the arrow")}</title>
      <polyline points=${pointsText(points)}></polyline>
      <polyline points=${pointsText(arrowHead(points, 7))}></polyline>
      ${first === undefined ? null : svg`<circle cx=${first.x} cy=${first.y} r="3"></circle>`}
    </svg>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-path-sketch": PathSketch;
  }
}
