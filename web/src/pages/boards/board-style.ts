/** The look of a board's page: its head, its tools, and how it fills a screen. */

import { css } from "lit";

export const boardStyle = css`
  :host([kiosk]) {
    position: fixed;
    inset: 0;
    z-index: 50;
    /* Below: the button that leads out covers no tile. */
    padding: var(--t-space-3) var(--t-space-3) calc(var(--t-touch) + 2 * var(--t-space-3));
    background: var(--t-bg);
    overflow: auto;
  }
  .tools {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    gap: var(--t-space-2);
  }
  .subjects {
    display: flex;
    flex-wrap: wrap;
    gap: var(--t-space-2);
  }
  .subjects label {
    display: inline-flex;
    align-items: center;
    gap: var(--t-space-2);
    font-size: var(--t-size-s);
  }
  .runs {
    display: grid;
    grid-template-columns: repeat(auto-fit, minmax(min(22rem, 100%), 1fr));
    gap: var(--t-space-4);
  }
  .run {
    margin-block-end: var(--t-space-2);
    font-size: var(--t-size-m);
  }
  .run span {
    color: var(--t-muted);
    font-variant-numeric: tabular-nums;
    font-weight: var(--t-weight);
  }
  .mark {
    display: grid;
    place-items: center;
    inline-size: 1.5rem;
    block-size: 1.5rem;
    padding: 0;
    border: 0;
    background: none;
    color: var(--t-muted);
    cursor: pointer;
  }
  .mark.bad {
    color: var(--t-bad);
  }
  .arrange {
    position: sticky;
    inset-block-start: 3.75rem;
    z-index: 10;
    display: flex;
    flex-wrap: wrap;
    align-items: end;
    gap: var(--t-space-2);
    padding: var(--t-space-2) var(--t-space-3);
    border: 1px solid var(--t-edge);
    border-radius: var(--t-radius);
    background: var(--t-surface);
  }
  .phone {
    inline-size: min(24rem, 100%);
    margin-inline: auto;
  }
  .named {
    display: grid;
    gap: var(--t-space-2);
    grid-template-columns: repeat(auto-fit, minmax(min(14rem, 100%), 1fr));
  }
  .leave {
    position: fixed;
    inset-block-end: var(--t-space-2);
    inset-inline-end: var(--t-space-2);
    z-index: 60;
  }
  @media (max-width: 45rem) {
    .arrange {
      position: static;
    }
  }
`;
