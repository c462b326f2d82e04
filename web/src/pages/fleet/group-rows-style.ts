/** How a list of robots looks that were asked for one thing: its head, and name, word, text and link of each. */

import { css } from "lit";
import { plainList, quietText } from "../../elements/base/base-style.js";

/** `--t-word` is the width of the column of words. */
export const groupRows = css`
  ul {
    display: grid;
    ${plainList}
  }
  li {
    display: grid;
    grid-template-columns: minmax(8rem, 1fr) var(--t-word) minmax(0, 3fr) auto;
    align-items: center;
    gap: 0 var(--t-space-4);
    padding-block: var(--t-space-2);
    border-block-start: 1px solid var(--t-line);
    overflow-wrap: anywhere;
  }
  @media (max-width: 45rem) {
    li {
      grid-template-columns: minmax(0, 1fr) auto;
    }
    .text {
      grid-column: 1 / -1;
    }
  }
  .name {
    font-weight: var(--t-weight-strong);
  }
  .text,
  .note {
    ${quietText}
  }
  .head {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    justify-content: space-between;
    gap: var(--t-space-2);
  }
`;
