import { css } from "lit";

export const chartStyle = css`
  :host {
    position: relative;
    display: block;
    block-size: 10rem;
    contain: strict;
  }
  .plot {
    position: absolute;
    inset: 0;
    overflow: hidden;
    touch-action: pan-y;
    border-radius: var(--t-radius-s);
  }
  .plot:focus-visible {
    outline-offset: -3px;
  }
  :host([zoomable]) .plot {
    cursor: crosshair;
  }
  .cursor,
  .chosen,
  .read {
    position: absolute;
    inset-block-start: 0;
    pointer-events: none;
  }
  .cursor {
    inset-inline-start: 0;
    inline-size: 1px;
    background: var(--t-text);
    opacity: 0.7;
  }
  .chosen {
    inset-inline-start: 0;
    background: color-mix(in srgb, var(--t-accent) 22%, transparent);
    border-inline: 1px solid var(--t-accent);
  }
  .read {
    inset-block-start: var(--t-space-2);
    max-inline-size: 60%;
    padding: var(--t-space-1) var(--t-space-2);
    border: 1px solid var(--t-edge);
    border-radius: var(--t-radius-s);
    background: var(--t-surface);
    color: var(--t-text);
    font-size: var(--t-size-s);
    font-variant-numeric: tabular-nums;
    line-height: 1.35;
    white-space: pre;
  }
`;
