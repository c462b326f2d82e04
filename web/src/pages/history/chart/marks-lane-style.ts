import { css } from "lit";
import { panelBox } from "../../../elements/base/base-style.js";

export const marksLaneStyle = css`
  :host {
    display: grid;
    gap: var(--t-space-1);
    padding: var(--t-space-2) var(--t-space-3);
    ${panelBox}
    min-inline-size: 0;
  }
  .head {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    gap: var(--t-space-1) var(--t-space-3);
    font-size: var(--t-size-s);
  }
  label {
    display: inline-flex;
    align-items: center;
    gap: var(--t-space-1);
    min-block-size: 1.75rem;
    cursor: pointer;
  }
  input {
    margin: 0;
  }
  svg {
    inline-size: 0.8rem;
    block-size: 0.8rem;
    color: var(--t-accent);
  }
  .alarm,
  .bad {
    color: var(--t-bad);
  }
  .stop {
    color: var(--t-warn);
  }
  .track {
    position: relative;
    block-size: 2rem;
    margin-inline: calc(-1 * var(--t-space-2));
  }
  .track::before {
    content: "";
    position: absolute;
    inset: 50% var(--right) auto var(--left);
    border-block-start: 1px solid var(--t-line);
  }
  .place {
    position: absolute;
    inset-block: 0;
    inset-inline: var(--left) var(--right);
  }
  button {
    position: absolute;
    inset-block: 0;
    display: grid;
    place-items: center;
    inline-size: 1.75rem;
    padding: 0;
    border: 0;
    border-radius: var(--t-radius-s);
    background: transparent;
    translate: -50% 0;
    cursor: pointer;
  }
  button:focus-visible {
    outline-offset: -2px;
  }
  button svg {
    inline-size: 1.05rem;
    block-size: 1.05rem;
    stroke: var(--t-surface);
  }
  button[aria-expanded="true"] {
    background: var(--t-raised);
  }
  .many {
    position: absolute;
    inset-block-start: 0;
    inset-inline-start: 55%;
    padding-inline: 0.25em;
    border-radius: 1em;
    background: var(--t-text);
    color: var(--t-surface);
    font-size: 0.6875rem;
    font-weight: var(--t-weight-strong);
    line-height: 1.25;
    font-variant-numeric: tabular-nums;
  }
  .tip {
    position: absolute;
    inset-block-start: 100%;
    z-index: 10;
    display: grid;
    gap: var(--t-space-2);
    inline-size: max-content;
    max-inline-size: min(26rem, 100%);
    max-block-size: 20rem;
    overflow-y: auto;
    padding: var(--t-space-2) var(--t-space-3);
    border: 1px solid var(--t-edge);
    border-radius: var(--t-radius-s);
    background: var(--t-surface);
    box-shadow: var(--t-shadow);
    font-size: var(--t-size-s);
    overflow-wrap: anywhere;
  }
  .tip p {
    display: grid;
    grid-template-columns: 1rem minmax(0, 1fr);
    gap: 0 var(--t-space-2);
    align-items: baseline;
  }
  .tip p > :not(svg) {
    grid-column: 2;
  }
  time {
    font-variant-numeric: tabular-nums;
  }
`;
