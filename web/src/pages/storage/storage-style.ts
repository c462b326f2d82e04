import { css } from "lit";
import { quietText } from "../../elements/base/base-style.js";

export const storageStyle = css`
  dl {
    display: grid;
    grid-template-columns: repeat(auto-fit, minmax(9.5rem, 1fr));
    gap: var(--t-space-4);
    margin: 0;
  }
  dl > div {
    display: grid;
    align-content: start;
    min-inline-size: 0;
  }
  dt {
    ${quietText}
    font-weight: var(--t-weight-strong);
  }
  dd {
    margin: 0;
    overflow-wrap: anywhere;
    font-variant-numeric: tabular-nums;
  }
  dd.large {
    font-size: var(--t-size-l);
    font-weight: var(--t-weight-strong);
  }
  .bar {
    display: flex;
    block-size: 0.75rem;
    border-radius: var(--t-radius-s);
    background: var(--t-raised);
    border: 1px solid var(--t-edge);
    overflow: hidden;
  }
  .bar .ours {
    background: var(--t-accent);
  }
  .bar .others {
    background: repeating-linear-gradient(45deg, var(--t-edge) 0 2px, transparent 2px 5px);
  }
  .key {
    display: flex;
    flex-wrap: wrap;
    gap: 0 var(--t-space-4);
    ${quietText}
  }
  .forecast {
    max-inline-size: 60rem;
  }
  code {
    overflow-wrap: anywhere;
  }
`;

export const storageTableStyle = css`
  :host {
    display: grid;
    grid-template-columns: minmax(0, 1fr);
    gap: var(--t-space-3);
  }
  .tools {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    gap: var(--t-space-2) var(--t-space-4);
  }
  input[type="search"] {
    flex: 1 1 12rem;
    max-inline-size: 22rem;
  }
  .sort {
    display: none;
    align-items: center;
    gap: var(--t-space-2);
    ${quietText}
    font-weight: var(--t-weight-strong);
  }
  .table {
    --t-columns: minmax(0, 2.4fr) minmax(7rem, 1.2fr) 6rem 7rem minmax(11rem, 1.4fr) 6rem;
  }
  .row:not(.titles) > .size {
    display: grid;
    grid-template-columns: minmax(2rem, 1fr) 4.75rem;
    align-items: center;
    gap: var(--t-space-2);
  }
  .row:not(.titles) > .size > :last-child {
    text-align: end;
  }
  .share {
    block-size: 0.4rem;
    border-radius: 0.2rem;
    background: var(--t-raised);
  }
  .share i {
    display: block;
    block-size: 100%;
    min-inline-size: 2px;
    border-radius: inherit;
    background: var(--t-accent);
  }
  @media (max-width: 60rem) {
    .sort {
      display: inline-flex;
    }
    .who,
    .size,
    .when {
      grid-column: 1 / -1;
    }
  }
`;
