import { css } from "lit";

export const supportStyle = css`
  p {
    max-inline-size: 42rem;
    overflow-wrap: anywhere;
  }
  p[role="status"]:empty {
    display: none;
  }
  dl {
    display: grid;
    gap: var(--t-space-2);
    margin: 0;
  }
  dl > div {
    display: grid;
    grid-template-columns: 9rem minmax(0, 1fr);
    gap: 0 var(--t-space-4);
  }
  dt {
    font-weight: var(--t-weight-strong);
  }
  dd {
    margin: 0;
    color: var(--t-muted);
  }
  @media (max-width: 45rem) {
    dl > div {
      grid-template-columns: minmax(0, 1fr);
    }
  }
`;
