/** The look of forms: fields side by side, as many as fit. */

import { css } from "lit";

export const forms = css`
  form {
    display: grid;
    gap: var(--t-space-3);
  }
  form:is(.filter, .entry) {
    display: grid;
    gap: var(--t-space-3) var(--t-space-4);
  }
  /* Says what a page shows. */
  form.filter {
    grid-template-columns: repeat(auto-fill, minmax(min(9.5rem, 100%), 1fr));
    align-items: end;
  }
  form.filter > :is(.time, .actions) {
    grid-column: span 2;
  }
  @media (min-width: 45.01rem) {
    /* Its words stand on one line. */
    form.filter > label.tick {
      grid-column: span 2;
    }
  }
  form.filter > t-button {
    justify-self: start;
  }
  /* Is filled in and sent. */
  form.entry {
    grid-template-columns: repeat(auto-fill, minmax(min(15rem, 100%), 1fr));
    align-items: start;
  }
  form.entry > :is(.actions, .wide, h2, p, t-problem, t-rules) {
    grid-column: 1 / -1;
  }
  label.tick {
    display: flex;
    align-items: center;
    gap: var(--t-space-2);
    min-block-size: var(--t-touch);
  }
  @media (max-width: 45rem) {
    form.filter {
      grid-template-columns: 1fr 1fr;
    }
    form.filter > :is(.time, .actions) {
      grid-column: 1 / -1;
    }
  }
`;
