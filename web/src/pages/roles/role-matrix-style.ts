import { css } from "lit";
import { panelBox, quietText } from "../../elements/base/base-style.js";

/* More right, more weight: an empty outline, a tinted one, a full one. The word says it besides. */
export const matrixStyle = css`
  :host {
    display: grid;
    gap: var(--t-space-3);
    min-inline-size: 0;
  }
  .narrow {
    display: none;
  }
  .scroll {
    overflow-x: auto;
    ${panelBox}
  }
  table {
    inline-size: 100%;
    border-collapse: separate;
    border-spacing: 0;
  }
  thead th {
    vertical-align: top;
    padding: var(--t-space-3) var(--t-space-2);
    border-block-end: 2px solid var(--t-line);
    text-align: center;
    font-weight: var(--t-weight);
    min-inline-size: 7.5rem;
  }
  .role {
    display: block;
    font-weight: var(--t-weight-strong);
    overflow-wrap: anywhere;
  }
  thead t-button {
    color: var(--t-accent);
  }
  .people {
    display: block;
    ${quietText}
  }
  tbody th {
    position: sticky;
    inset-inline-start: 0;
    z-index: 1;
    padding: var(--t-space-1) var(--t-space-4);
    background: var(--t-surface);
    text-align: start;
    font-weight: var(--t-weight);
    min-inline-size: 11rem;
  }
  .corner {
    position: sticky;
    inset-inline-start: 0;
    background: var(--t-surface);
    z-index: 1;
  }
  td {
    padding: var(--t-space-1) var(--t-space-2);
    text-align: center;
  }
  tr.d0 th,
  tr.d1 th {
    font-weight: var(--t-weight-strong);
  }
  tr.d1 > * {
    border-block-start: 1px solid var(--t-line);
  }
  tr.d2 .place {
    padding-inline-start: var(--t-space-4);
  }
  .public {
    padding-inline: 0.5em;
    border: 1px solid var(--t-line);
    border-radius: 1em;
    color: var(--t-muted);
    font-size: 0.75rem;
  }
  .cell {
    display: inline-block;
    inline-size: 100%;
    max-inline-size: 9rem;
    min-block-size: 2.5rem;
    padding: 0 var(--t-space-2);
    border: 1px solid var(--t-line);
    border-radius: var(--t-radius-s);
    background: transparent;
    color: var(--t-muted);
    font: inherit;
    font-weight: var(--t-weight-strong);
    line-height: 2.4rem;
    text-align: center;
    text-align-last: center;
  }
  .extra {
    display: inline-flex;
    align-items: center;
    gap: var(--t-space-1);
    margin-block-start: var(--t-space-1);
    padding-inline: var(--t-space-1);
    border-radius: var(--t-radius-s);
    color: var(--t-muted);
    font-size: var(--t-size-s);
  }
  .extra:has(:checked) {
    color: var(--t-text);
  }
  select.cell {
    cursor: pointer;
  }
  select.cell option {
    background: var(--t-surface);
    color: var(--t-text);
  }
  .view {
    border-color: var(--t-edge);
    background: var(--t-raised);
    color: var(--t-text);
  }
  .use {
    border-color: var(--t-accent);
    background: color-mix(in srgb, var(--t-accent) 18%, var(--t-surface));
    color: var(--t-text);
  }
  .admin {
    border-color: var(--t-accent);
    background: var(--t-accent);
    color: var(--t-on-accent);
  }
  /* Given by a line above: the same, with half the weight. */
  .from {
    border-style: dashed;
    color: var(--t-text);
    font-weight: var(--t-weight);
  }
  .from.view {
    background: color-mix(in srgb, var(--t-raised) 50%, var(--t-surface));
  }
  .from.use {
    background: color-mix(in srgb, var(--t-accent) 8%, var(--t-surface));
  }
  .from.admin {
    background: color-mix(in srgb, var(--t-accent) 26%, var(--t-surface));
  }
  .changed {
    outline: 3px solid var(--t-warn);
    outline-offset: 1px;
  }
  .cell:focus-visible {
    outline: 3px solid var(--t-accent);
    outline-offset: 2px;
  }
  @media (max-width: 45rem) {
    .narrow {
      display: block;
      --t-choice-basis: 5rem;
    }
    td:not(.shown),
    thead th:not(.shown, .corner) {
      display: none;
    }
    tbody th {
      min-inline-size: 0;
    }
    thead th {
      min-inline-size: 8.5rem;
    }
  }
`;
