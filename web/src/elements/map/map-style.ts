/** What both maps look like around their canvas. */

import { css } from "lit";
import { panelBox } from "../base/base-style.js";

export const mapFrame = css`
  :host {
    display: grid;
    /* At least so high; higher where whoever places it gives more. */
    grid-template-rows: minmax(var(--t-map-height, 20rem), 1fr);
  }
  .frame {
    position: relative;
    isolation: isolate;
    overflow: hidden;
    ${panelBox}
  }
  .frame:focus-within {
    border-color: var(--t-accent);
  }
  canvas,
  .leaflet {
    position: absolute;
    inset: 0;
    inline-size: 100%;
    block-size: 100%;
  }
  .leaflet.leaflet-container {
    background: transparent;
    font: inherit;
    z-index: 1;
  }
  .leaflet .leaflet-bar {
    border: 1px solid var(--t-edge);
    border-radius: var(--t-radius-s);
    box-shadow: none;
    overflow: hidden;
  }
  .leaflet .leaflet-bar a,
  .leaflet .leaflet-bar a.leaflet-disabled {
    inline-size: var(--t-touch);
    block-size: var(--t-touch);
    line-height: var(--t-touch);
    background: var(--t-surface);
    color: var(--t-text);
    border-color: var(--t-line);
    font: inherit;
    font-size: 1.375rem;
    line-height: 2.5rem;
  }
  .leaflet .leaflet-bar a:hover {
    background: var(--t-raised);
  }
  .leaflet .leaflet-bar a.leaflet-disabled {
    color: var(--t-muted);
    opacity: 0.6;
  }
  .scale {
    position: absolute;
    z-index: 2;
    inset: auto auto var(--t-space-2) var(--t-space-2);
    padding: 0 var(--t-space-2) 0.15rem;
    border-radius: var(--t-radius-s);
    background: var(--t-surface);
    font-size: var(--t-size-s);
    pointer-events: none;
  }
  .scale i {
    display: block;
    block-size: 6px;
    border: 2px solid currentColor;
    border-block-start: 0;
  }
  .note {
    position: absolute;
    z-index: 2;
    inset: 50% auto auto 50%;
    transform: translate(-50%, -50%);
    padding: var(--t-space-2) var(--t-space-3);
    border-radius: var(--t-radius-s);
    background: var(--t-surface);
    color: var(--t-muted);
    text-align: center;
    pointer-events: none;
  }
  .where {
    position: absolute;
    z-index: 2;
    inset: auto var(--t-space-2) var(--t-space-2) auto;
    max-inline-size: calc(100% - 6.5rem);
    padding: 0.1rem var(--t-space-2);
    border-radius: var(--t-radius-s);
    background: var(--t-surface);
    font-size: var(--t-size-s);
    font-variant-numeric: tabular-nums;
    text-align: end;
    pointer-events: none;
  }

  .stale {
    color: var(--t-stale);
    font-weight: var(--t-weight-strong);
  }
`;
