/** How a button that is held looks: under the finger, by keys, and when it is out of work. */

import { css } from "lit";

export const heldButton = css`
  button:hover:not(:disabled) {
    background: var(--t-raised);
  }
  button.held {
    border-color: var(--t-accent);
    background: var(--t-accent);
    color: var(--t-on-accent);
  }
  button:disabled {
    border-style: dashed;
    color: var(--t-muted);
    cursor: not-allowed;
    opacity: 0.6;
  }
`;
