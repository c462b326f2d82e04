/** The look of the form of a request. */

import { css } from "lit";

export const formStyle = css`
  fieldset {
    margin: 0;
    padding: var(--t-space-3) 0 0;
    border: 0;
    border-block-start: 1px solid var(--t-line);
    min-inline-size: 0;
  }
  fieldset,
  .inner {
    display: grid;
    grid-template-columns: repeat(auto-fill, minmax(min(12rem, 100%), 1fr));
    gap: var(--t-space-3) var(--t-space-4);
    align-items: start;
  }
  .inner {
    padding-block: var(--t-space-2) var(--t-space-3);
  }
  legend {
    float: inline-start;
    inline-size: 100%;
    padding: 0;
    font-weight: var(--t-weight-strong);
    grid-column: 1 / -1;
  }
  legend ~ .wide {
    grid-column: 1 / -1;
  }
  .frames,
  .window {
    display: grid;
    gap: var(--t-space-2) var(--t-space-3);
    grid-column: 1 / -1;
    align-items: start;
    padding-block-end: var(--t-space-3);
    border-block-end: 1px dashed var(--t-line);
  }
  .frames {
    grid-template-columns: repeat(auto-fill, minmax(min(6.5rem, 45%), 1fr));
  }
  .window {
    grid-template-columns: repeat(auto-fill, minmax(min(14rem, 100%), 1fr));
  }
  .requests {
    display: flex;
    flex-wrap: wrap;
    gap: var(--t-space-2);
    max-block-size: 14rem;
    overflow-y: auto;
    /* The ring of a focused button is not cut off. */
    padding: 4px;
  }
  .find {
    display: grid;
    grid-template-columns: minmax(0, 1fr) auto;
    gap: var(--t-space-2);
    align-items: start;
    grid-column: 1 / -1;
  }
  /* Level with the control, below the height of its label. */
  .find t-button,
  .window > t-button,
  .frames > t-button {
    margin-block-start: calc(var(--t-size-s) * 1.45 + var(--t-space-1));
    justify-self: start;
  }
  .wrong {
    color: var(--t-bad);
    font-weight: var(--t-weight-strong);
  }
`;
