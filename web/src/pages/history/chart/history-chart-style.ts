import { css } from "lit";
import { raisedBox, quietText } from "../../../elements/base/base-style.js";
import { seriesMarks } from "../../../elements/chart/series-marks.js";

export const historyChartStyle = css`
  :host {
    display: grid;
    gap: var(--t-space-2);
    padding: var(--t-space-3) var(--t-space-3) var(--t-space-2);
    ${raisedBox}
    min-inline-size: 0;
    container-type: inline-size;
  }
  t-chart {
    block-size: clamp(13rem, 34vh, 22rem);
    margin-inline: calc(-1 * var(--t-space-2));
  }
  t-chart.band {
    block-size: 5.5rem;
  }
  .place {
    position: relative;
  }
  .none {
    position: absolute;
    inset: 0 0 2rem;
    display: grid;
    place-content: center;
    justify-items: center;
    text-align: center;
    color: var(--t-muted);
    pointer-events: none;
  }
  .none > * {
    padding-inline: var(--t-space-2);
    background: var(--t-surface);
  }
  .none strong {
    color: var(--t-text);
  }
  .scroll {
    overflow-x: auto;
  }
  table {
    inline-size: 100%;
    border-collapse: collapse;
    font-size: var(--t-size-s);
    font-variant-numeric: tabular-nums;
  }
  th,
  td {
    padding: 0.2rem var(--t-space-3);
    text-align: end;
    white-space: nowrap;
    font-weight: var(--t-weight);
  }
  thead th {
    color: var(--t-muted);
  }
  th:first-child {
    inline-size: 100%;
    padding-inline-start: 0;
    text-align: start;
  }
  tbody th {
    font-weight: var(--t-weight-strong);
  }
  .at {
    min-inline-size: 11rem;
    font-weight: var(--t-weight-strong);
  }
  .other {
    color: var(--t-muted);
  }
  .rms {
    white-space: nowrap;
  }
  .then {
    display: block;
    color: var(--t-muted);
    font-weight: var(--t-weight);
  }
  .then::before {
    content: "┄ ";
  }
  .swatch {
    display: inline-block;
    inline-size: 1rem;
    block-size: 0.25rem;
    margin-inline-end: var(--t-space-2);
    border-radius: 2px;
    vertical-align: middle;
  }
  .why {
    color: var(--t-muted);
    font-weight: var(--t-weight);
  }
  summary {
    min-block-size: var(--t-touch);
    align-content: center;
    ${quietText}
    cursor: pointer;
  }
  ol {
    display: grid;
    gap: var(--t-space-1);
    max-block-size: 14rem;
    margin: 0;
    padding: 0;
    overflow-y: auto;
    list-style: none;
    font-size: var(--t-size-s);
  }
  time {
    color: var(--t-muted);
    font-variant-numeric: tabular-nums;
  }
  ${seriesMarks}
  /* Beside a film: the cells of all signals go before how far one reaches at the cursor. */
  @container (inline-size < 46rem) {
    .spread {
      display: none;
    }
    th,
    td {
      padding-inline: var(--t-space-2);
    }
    .at {
      min-inline-size: 8rem;
    }
  }
  @media (max-width: 45rem) {
    th,
    td {
      padding-inline: var(--t-space-2) 0;
    }
    th:first-child {
      inline-size: auto;
      min-inline-size: 5.5rem;
      white-space: normal;
    }
    .at {
      min-inline-size: 0;
      inline-size: 45%;
      white-space: normal;
    }
    tbody .muted,
    .roomy,
    .spread {
      display: none;
    }
  }
  .outliers {
    display: grid;
    gap: var(--t-space-1);
    margin: 0;
    padding: 0;
    ${quietText}
    font-variant-numeric: tabular-nums;
    list-style: none;
  }
  .outliers strong {
    color: var(--t-text);
  }
`;
