/** The path of a rehearsal from above: where it began, where it ends, and where driving would have been refused. */

import { msg } from "@lit/localize";
import { css, html, LitElement, svg, type SVGTemplateResult, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { RehearsalVerdict } from "../../generated/wire.js";
import type { FloorPose } from "../../scene/pose-command.js";
import { pathBox, pathStretches } from "../../scene/rehearsal.js";
import { base } from "../base/base-style.js";

/** Length of the arrow at the end, as a share of the picture. */
const ARROW = 0.07;

@customElement("t-rehearsal-map")
export class RehearsalMap extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        min-inline-size: 0;
      }
      svg {
        display: block;
        inline-size: 100%;
        max-block-size: 18rem;
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius-s);
        background: var(--t-bg);
      }
      .grid {
        stroke: var(--t-line);
      }
      .way {
        fill: none;
        stroke: var(--t-series-1);
      }
      .refused {
        stroke: var(--t-bad);
      }
      .slow {
        stroke: var(--t-warn);
      }
      .begin {
        fill: var(--t-bg);
        stroke: var(--t-text);
      }
      .end {
        fill: var(--t-text);
      }
    `,
  ];

  @property({ attribute: false }) poses: readonly FloorPose[] = [];
  @property({ attribute: false }) verdicts: readonly RehearsalVerdict[] = [];
  /** Said of it to who does not see it. */
  @property() label = msg("Path of the rehearsal");

  override render(): TemplateResult {
    const { x, y, size } = pathBox(this.poses);
    // REP-103 has y upwards, a screen downwards.
    return html`<svg viewBox="${x} ${-y - size} ${size} ${size}" role="img" aria-label=${this.label}>
      ${this.gridLines(x, y, size)} ${this.stretches(size)} ${this.ends(size)}
    </svg>`;
  }

  private gridLines(x: number, y: number, size: number): readonly SVGTemplateResult[] {
    // Ten lines at the most, a metre apart or a power of ten of it.
    const step = 10 ** Math.max(0, Math.ceil(Math.log10(size / 10)));
    const count = Math.ceil(size / step) + 1;
    const lines = Array.from({ length: count }, (_, number) => number * step);
    const left = Math.floor(x / step) * step;
    const low = Math.floor(y / step) * step;
    return lines.flatMap((at) => [
      svg`<line class="grid" stroke-width=${size / 400} x1=${left + at} x2=${left + at} y1=${-y - size} y2=${-y}></line>`,
      svg`<line class="grid" stroke-width=${size / 400} x1=${x} x2=${x + size} y1=${-(low + at)} y2=${-(low + at)}></line>`,
    ]);
  }

  private stretches(size: number): readonly SVGTemplateResult[] {
    return pathStretches(this.poses, this.verdicts).map(({ points, why, share }) => {
      const kind = why !== "" ? "refused" : share < 1 ? "slow" : "";
      // Refused is dashed, too: never by colour alone.
      return svg`<polyline class="way ${kind}" stroke-width=${size / 90} stroke-dasharray=${why === "" ? "none" : `${String(size / 40)} ${String(size / 60)}`}
        points=${points.map((point) => `${String(point.x)},${String(-point.y)}`).join(" ")}></polyline>`;
    });
  }

  private ends(size: number): SVGTemplateResult | null {
    const first = this.poses[0];
    const last = this.poses.at(-1);
    if (first === undefined || last === undefined) return null;
    const arrow = size * ARROW;
    return svg`<circle class="begin" cx=${first.x} cy=${-first.y} r=${size / 60} stroke-width=${size / 150}></circle>
      <path class="end" d="M ${arrow / 2} 0 L ${-arrow / 2} ${arrow / 3} L ${-arrow / 3} 0 L ${-arrow / 2} ${-arrow / 3} Z"
        transform="translate(${last.x} ${-last.y}) rotate(${(-last.yaw * 180) / Math.PI})"></path>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-rehearsal-map": RehearsalMap;
  }
}
