/** Zones and lines over a camera's picture, each with its name and what counts at it now. */

import { css, html, LitElement, nothing, svg, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ElementSizeController } from "../../controllers/element-size.js";
import { styled } from "../base/style-directive.js";
import { arrowHead, nameSpot, pointsText, viewPoints, type PictureMark } from "./mark-shapes.js";
import type { PixelSize } from "./picture-fit.js";
import { WHOLE, type Zoom } from "./zoom.js";

const ARROW_PX = 12;

/** Lies over the picture and takes nothing from it: presses go past. */
@customElement("t-picture-marks")
export class PictureMarks extends LitElement {
  /* White on black is seen on any picture, and is none of the colours of boxes. */
  static override styles = css`
    :host {
      display: block;
      position: absolute;
      inset: 0;
      overflow: hidden;
      pointer-events: none;
    }
    svg {
      position: absolute;
      inset: 0;
      inline-size: 100%;
      block-size: 100%;
    }
    .under {
      fill: none;
      stroke: #000;
      stroke-width: 4;
      stroke-opacity: 0.6;
      stroke-linejoin: round;
    }
    .over {
      fill: none;
      stroke: var(--t-box-thing);
      stroke-width: 1.5;
      stroke-linejoin: round;
    }
    .zone.over {
      stroke-dasharray: 6 4;
    }
    .name {
      position: absolute;
      translate: -50% -50%;
      max-inline-size: 12rem;
      padding: 0 0.4em;
      border-radius: 3px;
      background: rgb(0 0 0 / 78%);
      color: var(--t-box-thing);
      font-size: var(--t-size-s);
      line-height: 1.4;
      text-align: center;
      font-variant-numeric: tabular-nums;
    }
    strong {
      font-weight: var(--t-weight-strong);
      white-space: nowrap;
    }
  `;

  @property({ attribute: false }) marks: readonly PictureMark[] = [];
  /** Of the picture (px). */
  @property({ attribute: false }) picture: PixelSize = { width: 4, height: 3 };
  @property({ attribute: false }) zoom: Zoom = WHOLE;

  private readonly view = new ElementSizeController(this);

  override render(): TemplateResult | typeof nothing {
    if (this.view.size.width === 0) return nothing;
    const placed = this.marks.map((mark) => ({ mark, points: viewPoints(mark.points, this.view.size, this.picture, this.zoom) }));
    return html`<svg aria-hidden="true">
        ${map(placed, ({ mark, points }) => {
          const text = pointsText(points);
          if (mark.kind === "zone") return svg`<polygon class="under" points=${text}></polygon><polygon class="zone over" points=${text}></polygon>`;
          const head = pointsText(arrowHead(points, ARROW_PX));
          return svg`<polyline class="under" points=${text}></polyline><polyline class="under" points=${head}></polyline>
            <polyline class="line over" points=${text}></polyline><polyline class="over" points=${head}></polyline>`;
        })}
      </svg>
      ${map(placed, ({ mark, points }) => {
        const { x, y } = nameSpot(mark.kind, points);
        return html`<div class="name" data-mark=${mark.id} ${styled({ left: `${x.toFixed(1)}px`, top: `${y.toFixed(1)}px` })}>
          ${mark.name}${map(mark.counts, (count) => html` <strong>${count}</strong>`)}
        </div>`;
      })}`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-picture-marks": PictureMarks;
  }
}
