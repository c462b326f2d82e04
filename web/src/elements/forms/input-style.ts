/** How plain fields and selects look; a sheet for elements that have some. */

import { css } from "lit";

export const control = css`
  select,
  input:is([type="search"], [type="date"], [type="text"], [type="number"]) {
    min-inline-size: 0;
    min-block-size: var(--t-touch);
    padding: var(--t-space-2) var(--t-space-3);
    border: 1px solid var(--t-edge);
    border-radius: var(--t-radius-s);
    background: var(--t-surface);
    color: var(--t-text);
    font: inherit;
  }
  ::placeholder {
    color: var(--t-muted);
    opacity: 1;
  }
`;
