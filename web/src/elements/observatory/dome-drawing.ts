/** A dome or a roof that slides, drawn as its sensors say. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, svg, type PropertyValues, type SVGTemplateResult, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { formatAzimuth, wrapped } from "../../format/sexagesimal.js";
import { base } from "../base/base-style.js";
import { FLATNESS, groundPoint, SLIT, stripPolygon } from "./perspective.js";

export type RoofState = "open" | "closed" | "opening" | "closing" | "partial" | "error" | "unknown";

const EASE_MS = 450;
const HALF = 0.5;
/** South, from where the dome is seen. */
const IN_FRONT = 180;
const WORDS: Readonly<Record<RoofState, string>> = {
  open: msg("open"),
  closed: msg("closed"),
  opening: msg("opening"),
  closing: msg("closing"),
  partial: msg("partly open"),
  error: msg("in error"),
  unknown: msg("of unknown state"),
};
/** Degrees that a shell of a clamshell folds down. */
const FOLD = 100;
const WINDS = [[msg("N"), 0], [msg("E"), 90], [msg("S"), 180], [msg("W"), 270]] as const;

@customElement("t-dome-drawing")
export class DomeDrawing extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
      }
      svg {
        display: block;
        inline-size: 100%;
        max-block-size: 22rem;
        overflow: visible;
      }
      text {
        fill: var(--t-muted);
        font-size: 11px;
        font-weight: var(--t-weight-strong);
        text-anchor: middle;
        dominant-baseline: middle;
      }
      .line {
        fill: none;
        stroke: var(--t-edge);
        stroke-width: 1.5;
      }
      .shell {
        fill: var(--t-dome-shell);
        stroke: var(--t-edge);
        stroke-width: 1.5;
      }
      .wall {
        fill: var(--t-dome-shade);
        stroke: var(--t-edge);
        stroke-width: 1.5;
      }
      .door {
        fill: var(--t-dome-shade);
        stroke: var(--t-edge);
        stroke-width: 1;
      }
      .inside {
        fill: var(--t-dome-inside);
        stroke: var(--t-accent);
        stroke-width: 1.5;
      }
      .behind {
        fill: none;
        stroke: var(--t-edge);
        stroke-dasharray: 4 3;
      }
      .beam {
        stroke: var(--t-accent);
        stroke-width: 2.5;
        fill: var(--t-accent);
      }
      .telescope {
        stroke: var(--t-warn);
        stroke-width: 2;
        fill: none;
      }
      .veil {
        fill: url("#hatch");
        stroke: none;
      }
      .hatch {
        stroke: var(--t-stale);
        stroke-width: 2;
        opacity: 0.55;
      }
      .mark {
        fill: var(--t-surface);
        stroke: var(--t-stale);
        stroke-width: 2;
        stroke-dasharray: 4 3;
      }
      .question {
        fill: var(--t-text);
        font-size: 26px;
      }
      .error .shell,
      .error .wall {
        stroke: var(--t-bad);
        stroke-width: 3;
      }
      .moving .inside,
      .moving .door {
        animation: pulse 1.2s ease-in-out infinite alternate;
      }
      @keyframes pulse {
        from {
          stroke-opacity: 1;
        }
        to {
          stroke-opacity: 0.25;
        }
      }
    `,
  ];

  /** Where the slit looks (°); NaN when it is not known. */
  @property({ type: Number }) azimuth = Number.NaN;
  /** How far it is open, 0 to 1; NaN takes what the state says. */
  @property({ type: Number }) opening = Number.NaN;
  @property() roof: RoofState = "unknown";
  /** It turns; otherwise it is a roof that slides away. */
  @property({ type: Boolean }) turns = true;
  /** How far each shell of a clamshell is open, 0 to 1, the left one first; empty for another roof. */
  @property({ attribute: false }) segments: readonly number[] = [];
  /** Where it looks is not open to the person: it is drawn with the slit in front, and without a compass. */
  @property({ type: Boolean }) blind = false;
  @property({ type: Boolean }) turning = false;
  /** Where the telescope looks (°); NaN for none. */
  @property({ type: Number }) telescope = Number.NaN;
  /** What is drawn is the last that was known. */
  @property({ type: Boolean }) stale = false;

  /** What is shown: it follows what is true, so that the eye sees a motion. */
  @state() private at = Number.NaN;
  @state() private gap = 0;
  private frame = 0;

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    cancelAnimationFrame(this.frame);
  }

  protected override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("azimuth") || changed.has("opening") || changed.has("roof")) this.animateTurn();
  }

  override render(): TemplateResult {
    const unknown = this.roof === "unknown" || this.stale || (this.turns && !this.blind && Number.isNaN(this.azimuth));
    const moving = !this.stale && (this.turning || this.roof === "opening" || this.roof === "closing");
    return html`<svg
      viewBox=${this.turns ? "-205 -124 410 194" : this.segments.length > 0 ? "-195 -110 390 160" : "-170 -110 340 160"}
      role="img"
      aria-label=${this.describeDrawing()}
      class=${[moving ? "moving" : "", this.roof === "error" ? "error" : ""].join(" ")}
    >
      <defs>
        <pattern id="hatch" width="9" height="9" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
          <path class="hatch" d="M0 0V9"></path>
        </pattern>
      </defs>
      ${this.turns ? this.renderDome(unknown) : this.segments.length > 0 ? this.renderClamshell(unknown) : this.renderSlidingRoof(unknown)} ${unknown ? this.renderQuestion() : nothing}
    </svg>`;
  }

  /** The same in words, for whoever does not see it. */
  private describeDrawing(): string {
    const what = this.turns ? msg("The dome") : msg("The roof");
    const where = this.turns && !this.blind
      ? Number.isNaN(this.azimuth)
        ? msg("; where it looks is not known")
        : msg(str`, looking to azimuth ${formatAzimuth(this.azimuth, 0)}`)
      : "";
    const follows = Number.isNaN(this.telescope) ? "" : msg(str`; the telescope looks to azimuth ${formatAzimuth(this.telescope, 0)}`);
    return this.turning ? this.stale ? msg(str`${what} is ${WORDS[this.roof]}${where} and turning${follows}; this is the last that was known.`) : msg(str`${what} is ${WORDS[this.roof]}${where} and turning${follows}.`) : this.stale ? msg(str`${what} is ${WORDS[this.roof]}${where}${follows}; this is the last that was known.`) : msg(str`${what} is ${WORDS[this.roof]}${where}${follows}.`);
  }

  private renderDome(unknown: boolean): SVGTemplateResult {
    const azimuth = this.blind ? IN_FRONT : Number.isNaN(this.at) ? 0 : this.at;
    const tall = 100 * FLATNESS;
    const half = SLIT * this.gap;
    const wide = SLIT * 2;
    return svg`
      ${this.blind ? nothing : svg`${this.renderPlan()}${this.renderCompass()}`} ${Number.isNaN(this.at) ? nothing : this.renderPointer(azimuth)}
      <path class="wall" d="M-100 0V16A100 ${tall} 0 0 0 100 16V0A100 ${tall} 0 0 1 -100 0Z"></path>
      <path class="shell" d="M-100 0A100 100 0 0 1 100 0A100 ${tall} 0 0 1 -100 0Z"></path>
      ${Number.isNaN(this.at) && !this.blind
          ? nothing
          : svg`<polygon class="behind" points=${stripPolygon(azimuth, -SLIT, SLIT, true)}></polygon>
            ${this.renderPanel(azimuth, -SLIT - half, -half)} ${this.renderPanel(azimuth, half, Math.min(wide, SLIT + half))}
            ${this.gap > 0.01 ? svg`<polygon class="inside" points=${stripPolygon(azimuth, -half, half)}></polygon>` : nothing}`}
      ${unknown ? svg`<path class="veil" d="M-100 0A100 100 0 0 1 100 0A100 ${tall} 0 0 1 -100 0Z"></path>` : nothing}`;
  }

  private renderPanel(azimuth: number, from: number, to: number): SVGTemplateResult {
    return svg`<polygon class="door" points=${stripPolygon(azimuth, from, to)}></polygon>`;
  }

  private renderCompass(): SVGTemplateResult {
    const ticks = Array.from({ length: 24 }, (_, i) => {
      const [a, b] = [groundPoint(i * 15, 1.2), groundPoint(i * 15, i % 6 === 0 ? 1.28 : 1.24)];
      return svg`<path class="line" d="M${a.x * 100} ${a.y * 100 + 16}L${b.x * 100} ${b.y * 100 + 16}"></path>`;
    });
    const winds = WINDS.filter(([, azimuth]) => azimuth !== 0).map(([name, azimuth]) => {
      const { x, y } = groundPoint(azimuth, 1.4);
      return svg`<text x=${x * 100} y=${y * 100 + 16}>${name}</text>`;
    });
    return svg`<ellipse class="line" cx="0" cy="16" rx="120" ry=${120 * FLATNESS}></ellipse>${ticks}${winds}`;
  }

  /** The same from straight above, small: what the dome itself hides. */
  private renderPlan(): SVGTemplateResult {
    const winds = WINDS.map(([name, azimuth]) => {
      const { x, y } = pointOnRing(azimuth, 41);
      return svg`<text x=${x} y=${y}>${name}</text>`;
    });
    const tip = pointOnRing(this.telescope, 31);
    return svg`<g transform="translate(-148 -70)">
      <circle class="shell" r="30"></circle>
      ${winds}
      ${Number.isNaN(this.at)
          ? nothing
          : svg`<g transform="rotate(${this.at})">
              <path class=${this.gap > 0.01 ? "inside" : "door"} d="M-6 5V-29.4A30 30 0 0 1 6 -29.4V5Z"></path>
              <path class="beam" d="M0 -36l-5 9h10z"></path>
            </g>`}
      ${Number.isNaN(this.telescope) ? nothing : svg`<path class="telescope" d="M0 0L${tip.x} ${tip.y}"></path><circle class="telescope" r="3"></circle>`}
    </g>`;
  }

  /** Where the slit looks, on the ring round the dome. */
  private renderPointer(azimuth: number): SVGTemplateResult {
    const tip = groundPoint(azimuth, 1.2);
    const [left, right] = [groundPoint(azimuth - 5, 1.06), groundPoint(azimuth + 5, 1.06)];
    const at = ({ x, y }: { x: number; y: number }): string => `${String(x * 100)} ${String(y * 100 + 16)}`;
    return svg`<path class="beam" d="M${at(tip)}L${at(left)}L${at(right)}Z"></path>`;
  }

  private renderSlidingRoof(unknown: boolean): SVGTemplateResult {
    const way = 120 * this.gap;
    return svg`
      <path class="line" d="M-70 -20H150M-70 -20V40M150 -20V40"></path>
      <path class="wall" d="M-70 -20H60V40H-70Z"></path>
      ${this.gap > 0.01 ? svg`<path class="inside" d="M-68 -20H${Math.min(58, -68 + way).toFixed(1)}V-12H-68Z"></path>` : nothing}
      <g transform="translate(${way.toFixed(1)} 0)">
        <path class="shell" d="M-78 -20L-5 -70L68 -20Z"></path>
        ${unknown ? svg`<path class="veil" d="M-78 -20L-5 -70L68 -20Z"></path>` : nothing}
      </g>`;
  }

  /** Shells that fold down to both sides, each as far as it says itself; one that does not say is hatched. */
  private renderClamshell(unknown: boolean): SVGTemplateResult {
    const shells = this.segments.map((opening, index) => {
      const left = index < this.segments.length / 2;
      const silent = unknown || Number.isNaN(opening);
      const turn = (left ? -1 : 1) * FOLD * (silent ? 0 : Math.min(1, Math.max(0, opening)));
      const shape = left ? "M-80 0A80 80 0 0 1 0 -80V0Z" : "M80 0A80 80 0 0 0 0 -80V0Z";
      return svg`<g transform="rotate(${turn.toFixed(1)} ${left ? -80 : 80} 0)">
        <path class="shell" d=${shape}></path>${silent ? svg`<path class="veil" d=${shape}></path>` : nothing}
      </g>`;
    });
    return svg`<path class="inside" d="M-76 0A76 76 0 0 1 76 0Z"></path>${shells}<path class="wall" d="M-84 0H84V40H-84Z"></path>`;
  }

  private renderQuestion(): SVGTemplateResult {
    return svg`<circle class="mark" cx="0" cy="-46" r="20"></circle><text class="question" x="0" y="-44">?</text>`;
  }

  private targetAzimuth(): number {
    if (!Number.isNaN(this.opening)) return Math.min(1, Math.max(0, this.opening));
    if (this.roof === "open") return 1;
    return this.roof === "closed" || this.roof === "unknown" ? 0 : HALF;
  }

  /** Goes there by the shorter way, in less than the time between two values. */
  private animateTurn(): void {
    cancelAnimationFrame(this.frame);
    const [from, open] = [this.at, this.gap];
    const still = !this.blind && (Number.isNaN(from) || Number.isNaN(this.azimuth));
    if (!this.hasUpdated || (still && this.turns) || matchMedia("(prefers-reduced-motion: reduce)").matches) {
      this.at = this.azimuth;
      this.gap = this.targetAzimuth();
      return;
    }
    const way = this.turns && !this.blind ? wrapped(this.azimuth - from + 180, 360) - 180 : 0;
    const began = performance.now();
    const step = (now: number): void => {
      const part = Math.min(1, Math.max(0, (now - began) / EASE_MS));
      this.at = wrapped(from + way * part, 360);
      this.gap = open + (this.targetAzimuth() - open) * part;
      if (part < 1) this.frame = requestAnimationFrame(step);
    };
    this.frame = requestAnimationFrame(step);
  }
}

function pointOnRing(azimuth: number, far: number): { readonly x: number; readonly y: number } {
  const { x, y } = groundPoint(azimuth, far);
  return { x, y: y / FLATNESS };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-dome-drawing": DomeDrawing;
  }
}
