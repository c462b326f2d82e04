import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, svg, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { formatNumber } from "../../format/number.js";
import { KEPT_MS, type FieldTrace } from "../../topics/field-traces.js";
import { base, plainList, quietText } from "../base/base-style.js";
import "../base/icon.js";

const WIDE = 320;
const HIGH = 96;
/** Room above the highest and below the lowest, as a part of what lies between. */
const MARGIN = 0.08;

/**
 * Fields of a raw topic over the last minute, on one scale.
 *
 * @fires t-plot detail: the path of a field that is to be drawn no more
 */
@customElement("t-field-plot")
export class FieldPlot extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-1);
        min-inline-size: 0;
      }
      svg {
        inline-size: 100%;
        block-size: 7rem;
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius-s);
      }
      path {
        fill: none;
        stroke-width: 2;
        vector-effect: non-scaling-stroke;
      }
      ul {
        ${plainList}
        display: flex;
        flex-wrap: wrap;
        gap: 0 var(--t-space-4);
      }
      li {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
        font-family: var(--t-mono);
        font-size: var(--t-size-s);
        overflow-wrap: anywhere;
      }
      .swatch {
        flex: none;
        inline-size: 0.9rem;
        block-size: 0.25rem;
      }
      .s1 {
        stroke: var(--t-series-1);
        background: var(--t-series-1);
      }
      .s2 {
        stroke: var(--t-series-2);
        background: var(--t-series-2);
        stroke-dasharray: 6 3;
      }
      .s3 {
        stroke: var(--t-series-3);
        background: var(--t-series-3);
        stroke-dasharray: 2 3;
      }
      .s4 {
        stroke: var(--t-series-4);
        background: var(--t-series-4);
        stroke-dasharray: 9 3 2 3;
      }
      button {
        display: inline-grid;
        place-items: center;
        min-inline-size: 1.75rem;
        min-block-size: 1.75rem;
        padding: 0;
        border: 0;
        background: none;
        color: var(--t-muted);
        cursor: pointer;
      }
      @media (pointer: coarse) {
        button {
          min-inline-size: var(--t-touch);
          min-block-size: var(--t-touch);
        }
      }
      p {
        ${quietText}
        font-variant-numeric: tabular-nums;
      }
    `,
  ];

  @property({ attribute: false }) traces: readonly FieldTrace[] = [];
  /** The right edge (`performance.now`). */
  @property({ type: Number, attribute: "now-ms" }) nowMs = 0;

  override render(): TemplateResult | typeof nothing {
    const { traces } = this;
    if (traces.length === 0) return nothing;
    const values = traces.flatMap(({ points }) => points.map(({ value }) => value));
    const [low, high] = [Math.min(...values), Math.max(...values)];
    return html`${values.length === 0
        ? html`<p role="status">${msg("No number yet; the next message begins the line.")}</p>`
        : html`<svg viewBox="0 0 ${WIDE} ${HIGH}" preserveAspectRatio="none" role="img" aria-label=${msg(str`${traces.map(({ path }) => path).join(", ")} over the last minute`)}>
              ${map(traces, ({ points }, at) => svg`<path class=${`s${String(at + 1)}`} d=${this.line(points, low, high)}></path>`)}
            </svg>
            <p>${msg(str`The last minute, ${formatNumber(low, digitsFor(high - low))} to ${formatNumber(high, digitsFor(high - low))}`)}</p>`}
      <ul>
        ${repeat(
          traces,
          ({ path }) => path,
          ({ path, points }, at) => html`<li>
            <span class=${`swatch s${String(at + 1)}`}></span>${path} ${points.length === 0 ? "–" : formatNumber(points.at(-1)?.value ?? Number.NaN, digitsFor(high - low))}
            <button aria-label=${msg(str`Plot ${path} no more`)} data-path=${path} @click=${this.onRemove}>✕</button>
          </li>`,
        )}
      </ul>`;
  }

  private line(points: FieldTrace["points"], low: number, high: number): string {
    const room = (high - low || 1) * MARGIN;
    const [from, to] = high === low ? [low - 1, high + 1] : [low - room, high + room];
    return points
      .map(({ atMs, value }, at) => {
        const x = WIDE * (1 - (this.nowMs - atMs) / KEPT_MS);
        const y = HIGH * (1 - (value - from) / (to - from));
        return `${at === 0 ? "M" : "L"}${x.toFixed(1)} ${y.toFixed(1)}`;
      })
      .join("");
  }

  private readonly onRemove = (event: Event): void => {
    if (event.currentTarget instanceof HTMLElement) this.dispatchEvent(new CustomEvent("t-plot", { detail: event.currentTarget.dataset["path"] ?? "" }));
  };
}

/** As many digits as tell two values of such a span apart. */
function digitsFor(span: number): number {
  return span > 0 ? Math.min(6, Math.max(0, 2 - Math.floor(Math.log10(span)))) : 3;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-field-plot": FieldPlot;
  }
}
