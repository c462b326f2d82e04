/** How high a target stands through one night, over bands of twilight. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, svg, type SVGTemplateResult, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { formatClock } from "../../format/time.js";
import { DARKNESS, type NightTrack, type Visibility } from "../../sky/night-visibility.js";
import { base, plainList, quietText } from "../base/base-style.js";

const [WIDE, TALL, LEFT, TOP, LOW] = [600, 200, 34, 8, 24];
const HOUR_MS = 3_600_000;

@customElement("t-night-curve")
export class NightCurve extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-1);
      }
      svg {
        display: block;
        inline-size: 100%;
        block-size: auto;
        overflow: visible;
      }
      text {
        fill: var(--t-muted);
        font-size: 12px;
        dominant-baseline: middle;
      }
      .hour {
        text-anchor: middle;
      }
      .height {
        text-anchor: end;
      }
      .day {
        fill: var(--t-hour-day);
      }
      .civil {
        fill: var(--t-hour-civil);
      }
      .nautical {
        fill: var(--t-hour-nautical);
      }
      .astronomical {
        fill: var(--t-hour-astronomical);
      }
      .night {
        fill: var(--t-hour-night);
      }
      .grid {
        stroke: var(--t-edge);
        stroke-opacity: 0.35;
        stroke-width: 1;
      }
      .limit {
        stroke: var(--t-warn);
        stroke-width: 1.5;
        stroke-dasharray: 6 4;
      }
      .curve {
        fill: none;
        stroke: var(--t-text);
        stroke-width: 2.5;
        stroke-linejoin: round;
      }
      .moon {
        fill: none;
        stroke: var(--t-text);
        stroke-opacity: 0.6;
        stroke-width: 1.4;
        stroke-dasharray: 2 4;
      }
      .now {
        stroke: var(--t-bad);
        stroke-width: 2;
      }
      .at {
        fill: var(--t-bad);
      }
      .allowed {
        fill: var(--t-ok);
        stroke: var(--t-surface);
      }
      .best {
        fill: var(--t-text);
        stroke: var(--t-surface);
        stroke-width: 1.5;
      }
      .key {
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-1) var(--t-space-4);
        ${plainList}
        ${quietText}
      }
      .key li {
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-1);
      }
      .key svg {
        inline-size: 1.6em;
        block-size: 0.8em;
      }
      @media (max-width: 45rem) {
        text {
          font-size: 20px;
        }
        .key {
          gap: 0 var(--t-space-3);
        }
      }
    `,
  ];

  @property({ attribute: false }) night: NightTrack | null = null;
  @property({ attribute: false }) seen: Visibility | null = null;
  /** Altitude of the Moon at each of the night's points (°). */
  @property({ attribute: false }) moon: readonly number[] = [];
  /** The telescope may not point lower (°). */
  @property({ type: Number }) limit = 0;
  @property({ type: Number }) ms = 0;
  @property() zone = "UTC";
  /** While the target may be observed (ms); none are drawn where nobody asked. */
  @property({ attribute: false }) allowed: readonly { readonly from: number; readonly to: number }[] | null = null;
  /** The same in words. */
  @property() words = "";

  override render(): TemplateResult | typeof nothing {
    const { night, seen } = this;
    if (night === null || seen === null) return nothing;
    const path = (alts: readonly number[]): string => alts.map((alt, i) => `${i === 0 ? "M" : "L"}${this.xOfTime(night.points[i]?.ms ?? 0).toFixed(1)} ${yOfAltitude(alt).toFixed(1)}`).join("");
    return html`<svg viewBox="0 0 ${WIDE} ${TALL + LOW}" role="img" aria-label=${msg(str`Altitude over the night. ${this.words}`)}>
        <clipPath id="frame"><rect x=${LEFT} y="0" width=${WIDE - LEFT} height=${TALL}></rect></clipPath>
        ${map(
          night.bands,
          ({ id, from, to }) => svg`<rect class=${id} x=${this.xOfTime(from)} y=${TOP} width=${this.xOfTime(to) - this.xOfTime(from)} height=${TALL - TOP}></rect>`,
        )}
        ${map(
          [0, 30, 60, 90],
          (alt) => svg`<path class="grid" d="M${LEFT} ${yOfAltitude(alt)}H${WIDE}"></path><text class="height" x=${LEFT - 5} y=${yOfAltitude(alt)}>${alt}°</text>`,
        )}
        ${this.renderHours(night)}
        ${this.limit > 0 ? svg`<path class="limit" d="M${LEFT} ${yOfAltitude(this.limit)}H${WIDE}"></path>` : nothing}
        <g clip-path="url(#frame)">
          <path class="moon" d=${path(this.moon)}></path>
          <path class="curve" d=${path(night.points.map(({ alt }) => alt))}></path>
        </g>
        ${map(this.allowed ?? [], ({ from, to }) => svg`<rect class="allowed" x=${this.xOfTime(from)} y=${TALL - 8} width=${this.xOfTime(to) - this.xOfTime(from)} height="8"></rect>`)}
        ${this.renderMarks(night, seen)}
      </svg>
      ${this.renderLegend()}`;
  }

  private renderHours(night: NightTrack): SVGTemplateResult[] {
    const first = Math.ceil(night.from / HOUR_MS);
    const hours = Array.from({ length: 24 }, (_, i) => (first + i) * HOUR_MS).filter((ms) => ms < night.to);
    return hours.flatMap((ms) => {
      const clock = formatClock(ms * 1000, this.zone);
      return Number(clock.slice(0, 2)) % 3 === 0
        ? [svg`<path class="grid" d="M${this.xOfTime(ms)} ${TOP}V${TALL}"></path><text class="hour" x=${this.xOfTime(ms)} y=${TALL + 13}>${clock.slice(0, 2)}</text>`]
        : [];
    });
  }

  private renderMarks(night: NightTrack, seen: Visibility): SVGTemplateResult {
    const now = night.points.reduce((near, point) => (Math.abs(point.ms - this.ms) < Math.abs(near.ms - this.ms) ? point : near));
    return svg`
      ${this.ms < night.from || this.ms > night.to
          ? nothing
          : svg`<path class="now" d="M${this.xOfTime(this.ms)} ${TOP}V${TALL}"></path>
              ${now.alt >= 0 ? svg`<circle class="at" cx=${this.xOfTime(this.ms)} cy=${yOfAltitude(now.alt)} r="5"></circle>` : nothing}`}
      ${seen.best >= 0 ? svg`<path class="best" d="M${this.xOfTime(seen.bestMs)} ${yOfAltitude(seen.best) - 7}l7 7l-7 7l-7 -7z"></path>` : nothing}`;
  }

  private renderLegend(): TemplateResult {
    const renderMark = (what: SVGTemplateResult, name: string): TemplateResult =>
      html`<li><svg viewBox="0 0 32 16" aria-hidden="true">${what}</svg>${name}</li>`;
    return html`<ul class="key" aria-hidden="true">
      ${renderMark(svg`<path class="curve" d="M0 8H32"></path>`, msg("target"))} ${renderMark(svg`<path class="moon" d="M0 8H32"></path>`, msg("Moon"))}
      ${renderMark(svg`<path class="now" d="M16 0V16"></path>`, msg("now"))}
      ${this.limit > 0 ? renderMark(svg`<path class="limit" d="M0 8H32"></path>`, msg("lowest allowed")) : nothing}
      ${this.allowed === null ? nothing : renderMark(svg`<rect class="allowed" y="4" width="32" height="8"></rect>`, msg("may be observed"))}
      ${map(DARKNESS, ({ id, name }) => renderMark(svg`<rect class="${id} grid" width="32" height="16"></rect>`, name))}
    </ul>`;
  }

  private xOfTime(ms: number): number {
    const { from = 0, to = 1 } = this.night ?? {};
    return LEFT + ((WIDE - LEFT) * (ms - from)) / (to - from);
  }
}

function yOfAltitude(alt: number): number {
  return TALL - ((TALL - TOP) * Math.max(-5, alt)) / 90;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-night-curve": NightCurve;
  }
}
