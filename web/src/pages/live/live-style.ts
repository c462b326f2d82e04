import { css } from "lit";
import { quietText } from "../../elements/base/base-style.js";

export const liveStyle = css`
  :host {
    display: grid;
    gap: var(--t-space-5);
    min-inline-size: 0;
  }
  .top {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    justify-content: space-between;
    gap: var(--t-space-3) var(--t-space-5);
  }
  .title {
    display: flex;
    flex-wrap: wrap;
    align-items: baseline;
    gap: 0 var(--t-space-3);
  }
  .tools {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    gap: var(--t-space-2);
  }
  input[type="search"] {
    flex: 1 1 9rem;
  }
  .said {
    ${quietText}
  }
  .said:empty {
    display: none;
  }
  kbd {
    padding: 0 0.4em;
    border: 1px solid currentColor;
    border-radius: 3px;
    font-family: inherit;
    font-size: 0.75em;
    opacity: 0.85;
  }
  .count {
    color: var(--t-muted);
    font-variant-numeric: tabular-nums;
  }
  section {
    display: grid;
    gap: var(--t-space-3);
    min-inline-size: 0;
  }
  .charts {
    display: grid;
    grid-template-columns: repeat(auto-fill, minmax(min(23rem, 100%), 1fr));
    gap: var(--t-space-3);
  }
  @media (max-width: 45rem) {
    .tools {
      inline-size: 100%;
    }
    kbd {
      display: none;
    }
  }
  @media (pointer: coarse) {
    kbd {
      display: none;
    }
  }
`;
