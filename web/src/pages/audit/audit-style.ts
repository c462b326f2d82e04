import { css } from "lit";
import { quietText } from "../../elements/base/base-style.js";

export const auditStyle = css`
  .table {
    --t-columns: 15rem minmax(7rem, 1fr) minmax(0, 3fr) minmax(6rem, 1fr) 6.5rem;
  }
  .row {
    align-items: baseline;
  }
  .paging {
    justify-content: center;
  }
  @media (max-width: 60rem) {
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
      ${quietText}
    }
  }
`;
