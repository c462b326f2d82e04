/** The look of the pages before the dashboard: one quiet form in the middle. */

import { css } from "lit";
import { raisedBox } from "../base/base-style.js";

export const doorway = css`
  :host {
    display: grid;
    place-items: start center;
    padding-block: clamp(var(--t-space-3), 9dvh, 7rem) var(--t-space-6);
  }
  form,
  .sheet {
    display: grid;
    gap: var(--t-space-4);
    inline-size: min(23rem, 100%);
    padding: var(--t-space-5);
    ${raisedBox}
  }
  @media (max-height: 30rem) {
    :host {
      padding-block: 0;
    }
    form,
    .sheet {
      gap: var(--t-space-2);
      padding: var(--t-space-3) var(--t-space-4) var(--t-space-4);
    }
  }
  t-button {
    margin-block-start: var(--t-space-2);
  }
`;
