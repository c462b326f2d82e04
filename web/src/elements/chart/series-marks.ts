import { css } from "lit";

/** The colour of a chart's line as a mark's ground, by its number: `c1` to `c8`. */
export const seriesMarks = css`
  .c1 {
    background: var(--t-series-1);
  }
  .c2 {
    background: var(--t-series-2);
  }
  .c3 {
    background: var(--t-series-3);
  }
  .c4 {
    background: var(--t-series-4);
  }
  .c5 {
    background: var(--t-series-5);
  }
  .c6 {
    background: var(--t-series-6);
  }
  .c7 {
    background: var(--t-series-7);
  }
  .c8 {
    background: var(--t-series-8);
  }
`;
