/** Style of a chart's tile, and how the parts of a position are written. */

import { msg } from "@lit/localize";
import { css } from "lit";
import { raisedBox, quietText } from "../../elements/base/base-style.js";
import { formatNumber } from "../../format/number.js";
import { shownText } from "../../format/unit.js";
import type { SignalShape } from "../../generated/api.js";

export interface PositionPart {
  readonly name: string;
  readonly text: string;
}

const NAMES: Readonly<Record<string, string>> = {
  x: msg("East"),
  y: msg("North"),
  yaw: msg("Heading"),
  lat: msg("Latitude"),
  lon: msg("Longitude"),
  alt: msg("Altitude"),
};
/** Six digits of a degree are about a tenth of a metre. */
const DEGREE_DIGITS = 6;

/** One number of a position. A heading is turned to degrees: nobody reads radians at a glance. */
export function positionPart(signal: SignalShape, channel: string, value: number): PositionPart {
  const id = channel.slice(channel.lastIndexOf(".") + 1);
  const name = signal.frame === "local" && (id === "x" || id === "y") ? id : (NAMES[id] ?? id);
  if (Number.isNaN(value)) return { name, text: "–" };
  if (id === "yaw") return { name, text: `${formatNumber((value * 180) / Math.PI, 0)}°` };
  if (id === "lat" || id === "lon") return { name, text: `${formatNumber(value, DEGREE_DIGITS)}°` };
  return { name, text: shownText({ unit: "m", decimals: signal.decimals, shown: signal.shown }, value) };
}

export const tileStyle = css`
  :host {
    display: flex;
    flex-direction: column;
    gap: var(--t-space-1);
    padding: var(--t-space-3) var(--t-space-3) var(--t-space-2);
    ${raisedBox}
    min-inline-size: 0;
    contain: content;
  }
  :host([stale]) {
    border-style: dashed;
    border-color: var(--t-stale);
  }
  .head {
    display: flex;
    align-items: center;
    gap: var(--t-space-3);
    min-block-size: var(--t-touch);
  }
  h3 {
    flex: 1;
    min-inline-size: 0;
    overflow: hidden;
    text-overflow: ellipsis;
    white-space: nowrap;
  }
  t-status {
    font-size: var(--t-size-s);
    white-space: nowrap;
  }
  .pause {
    margin-inline-end: calc(-1 * var(--t-space-2));
  }
  .pause svg {
    inline-size: 1rem;
    block-size: 1rem;
  }
  .number {
    display: flex;
    flex-wrap: wrap;
    align-items: baseline;
    justify-content: space-between;
    gap: 0 var(--t-space-4);
  }
  .range {
    display: flex;
    gap: var(--t-space-3);
    ${quietText}
    font-variant-numeric: tabular-nums;
  }
  .range b {
    color: var(--t-text);
    font-weight: var(--t-weight-strong);
  }
  .text {
    font-size: var(--t-size-l);
    font-weight: var(--t-weight-strong);
    overflow-wrap: anywhere;
  }
  .text t-icon {
    vertical-align: -0.25em;
  }
  .text.warn {
    color: var(--t-warn);
  }
  .text.bad {
    color: var(--t-bad);
  }
  :host([stale]) .text {
    color: var(--t-stale);
    font-weight: var(--t-weight);
  }
  :host(:is(.number, .position, .text)) {
    align-self: start;
  }
  .parts {
    display: flex;
    flex-wrap: wrap;
    gap: var(--t-space-2) var(--t-space-5);
    margin: 0 0 var(--t-space-2);
  }
  dt {
    ${quietText}
  }
  dd {
    margin: 0;
  }
  t-chart {
    block-size: 9.5rem;
    margin-inline: calc(-1 * var(--t-space-2));
  }
  t-chart.state {
    block-size: 5rem;
    margin-block-start: auto;
  }
  t-detector {
    padding-block-start: var(--t-space-1);
    border-block-start: 1px solid var(--t-line);
  }
  .outliers {
    ${quietText}
    font-variant-numeric: tabular-nums;
  }
  .still {
    color: var(--t-warn);
    font-size: var(--t-size-s);
    font-weight: var(--t-weight-strong);
  }
`;
