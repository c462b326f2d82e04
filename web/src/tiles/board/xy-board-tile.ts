/** One number over another, the newest point marked. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, svg, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { StoreController } from "../../controllers/store-controller.js";
import { TickerController } from "../../controllers/ticker.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { decimalsFor, formatNumber } from "../../format/number.js";
import { shownUnit } from "../../format/unit.js";
import { formatAge } from "../../format/duration.js";
import type { SignalShape } from "../../generated/api.js";
import { roomFor, xyPairs } from "../../boards/xy-pairs.js";
import { SECOND_US } from "../../series/zone-clock.js";
import type { BoardTileContext } from "./board-tile-entry.js";

const REFRESH_MS = 250;
const WIDE = 320;
const HIGH = 240;

@customElement("t-tile-xy")
export class XyBoardTile extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-rows: minmax(0, 1fr) auto;
        block-size: 100%;
        min-block-size: 0;
      }
      svg {
        inline-size: 100%;
        block-size: 100%;
        min-block-size: 0;
      }
      .edge {
        fill: none;
        stroke: var(--t-line);
      }
      path {
        fill: none;
        stroke: var(--t-series-1);
        stroke-width: 2;
        vector-effect: non-scaling-stroke;
      }
      .newest {
        fill: var(--t-series-2);
      }
      .old path {
        stroke: var(--t-stale);
        stroke-dasharray: 4 3;
      }
      p {
        ${quietText}
        font-variant-numeric: tabular-nums;
      }
    `,
  ];

  @property({ attribute: false }) context: BoardTileContext | null = null;
  @property({ attribute: false }) across: SignalShape | null = null;
  @property({ attribute: false }) upwards: SignalShape | null = null;
  @property({ type: Number }) seconds = 300;

  private readonly watched = new StoreController(this);

  constructor() {
    super();
    new TickerController(this, REFRESH_MS);
  }

  override willUpdate(): void {
    this.watched.setStore(this.context?.past ?? null);
  }

  override render(): TemplateResult | typeof nothing {
    const { across, upwards } = this;
    const feed = this.context?.feed ?? null;
    if (across === null || upwards === null) return nothing;
    const [x, y] = [across, upwards].map((signal) => feed?.channelOf(signal.channels[0] ?? signal.address));
    const fromUs = (feed?.currentWindow(performance.now()).toUs ?? 0) - this.seconds * SECOND_US;
    const allowedUs = Math.max(across.max_age, upwards.max_age) * SECOND_US;
    const points = x === undefined || y === undefined ? [] : xyPairs(x.trace, y.trace, fromUs, allowedUs);
    const [left, right] = roomFor(points.map((point) => point.x));
    const [low, high] = roomFor(points.map((point) => point.y));
    const drawn = points.map((point) => [((point.x - left) / (right - left)) * WIDE, HIGH - ((point.y - low) / (high - low)) * HIGH] as const);
    const newest = drawn.at(-1);
    const path = drawn.map(([px, py], i) => `${i === 0 ? "M" : "L"}${px.toFixed(1)} ${py.toFixed(1)}`).join("");
    // The feed holds values as they are shown.
    const text = (signal: SignalShape, value: number): string => {
      const { unit, decimals } = shownUnit(signal);
      return `${formatNumber(value, decimalsFor(unit, decimals))} ${unit}`.trim();
    };
    const age = feed?.ageS(across.channels[0] ?? across.address) ?? Number.NaN;
    const old = this.context?.online !== true || !(age <= across.max_age);
    const last = points.at(-1);
    return html`<svg viewBox="0 0 ${WIDE} ${HIGH}" preserveAspectRatio="none" class=${old ? "old" : ""} role="img" aria-label=${msg(str`${upwards.name} over ${across.name}`)}>
        <rect class="edge" width=${WIDE} height=${HIGH}></rect>
        <path d=${path}></path>
        ${newest === undefined ? nothing : svg`<circle class="newest" cx=${newest[0]} cy=${newest[1]} r="5"></circle>`}
      </svg>
      <p>
        ${last === undefined
          ? msg("No point yet: both must be known at one moment.")
          : html`${msg(html`${across.name} ${text(across, last.x)}, ${upwards.name} ${text(upwards, last.y)}${old ? msg(str`; stale, ${formatAge(age)}`) : nothing}. Across ${text(across, left)} to ${text(across, right)}, upwards ${text(upwards, low)} to ${text(upwards, high)}.`)}`}
      </p>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-xy": XyBoardTile;
  }
}
