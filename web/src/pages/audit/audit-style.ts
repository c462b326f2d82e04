import { css } from "lit";

export const auditStyle = css`
  .export {
    display: inline-flex;
    align-items: center;
    min-block-size: var(--t-touch);
    padding-inline: var(--t-space-3);
    font-weight: var(--t-weight-strong);
  }
  .table {
    border: 1px solid var(--t-line);
    border-radius: var(--t-radius);
    background: var(--t-surface);
    overflow: hidden;
  }
  .row {
    display: grid;
    grid-template-columns: 15rem minmax(7rem, 1fr) minmax(0, 3fr) minmax(6rem, 1fr) 6.5rem;
    gap: var(--t-space-1) var(--t-space-4);
    align-items: baseline;
    padding: var(--t-space-2) var(--t-space-4);
  }
  .row + .row {
    border-block-start: 1px solid var(--t-line);
  }
  .titles {
    color: var(--t-muted);
    font-size: var(--t-size-s);
    font-weight: var(--t-weight-strong);
    background: var(--t-raised);
  }
  .row > span {
    min-inline-size: 0;
    overflow-wrap: anywhere;
  }
  .small {
    font-size: var(--t-size-s);
  }
  .paging {
    justify-content: center;
  }
  @media (max-width: 60rem) {
    .titles {
      position: absolute;
      clip-path: inset(50%);
    }
    .row {
      grid-template-columns: minmax(0, 1fr) auto;
      padding-block: var(--t-space-3);
    }
    .when,
    .what {
      grid-column: 1 / -1;
    }
    .when {
      font-size: var(--t-size-s);
    }
    .what {
      order: -1;
    }
    .where {
      order: 1;
      grid-column: 1 / -1;
      color: var(--t-muted);
      font-size: var(--t-size-s);
    }
  }
`;
