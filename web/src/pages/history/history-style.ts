import { css } from "lit";
import { panelBox, quietText } from "../../elements/base/base-style.js";

export const historyStyle = css`
  :host {
    display: grid;
    gap: var(--t-space-4);
    min-inline-size: 0;
  }
  .title {
    display: flex;
    flex-wrap: wrap;
    align-items: baseline;
    gap: 0 var(--t-space-3);
  }
  .utc {
    ${quietText}
    font-variant-numeric: tabular-nums;
  }
  .menus {
    position: relative;
    display: flex;
    flex-wrap: wrap;
    align-self: center;
    margin-inline-start: auto;
    font-weight: var(--t-weight-strong);
  }
  .menus .way {
    display: inline-flex;
    align-items: center;
    min-block-size: var(--t-touch);
    padding-inline: var(--t-space-3);
    color: var(--t-text);
    text-decoration: none;
  }
  .menus .way:hover {
    text-decoration: underline;
  }
  .then {
    ${quietText}
    font-weight: var(--t-weight-strong);
  }
  .body {
    display: grid;
    grid-template-columns: minmax(14rem, 17rem) minmax(0, 1fr);
    gap: var(--t-space-4);
    align-items: start;
  }
  .pick {
    padding: var(--t-space-3);
    ${panelBox}
  }
  summary {
    min-block-size: var(--t-touch);
    align-content: center;
    font-weight: var(--t-weight-strong);
    cursor: pointer;
  }
  .count {
    padding: 0 0.5em;
    border-radius: 1em;
    background: var(--t-raised);
    font-variant-numeric: tabular-nums;
  }
  .charts {
    position: relative;
    display: grid;
    gap: var(--t-space-3);
    min-inline-size: 0;
  }
  .progress {
    position: absolute;
    inset: -0.4rem 0 auto;
    block-size: 3px;
    border-radius: 2px;
    background: linear-gradient(90deg, transparent, var(--t-accent), transparent) 0 / 40% 100% no-repeat;
    animation: pass 1s 0.3s linear infinite both;
  }
  @keyframes pass {
    from {
      background-position: -60% 0;
    }
    to {
      background-position: 160% 0;
    }
  }
  .hint {
    ${quietText}
  }
  /* Where there is room the films stand beside the charts, else above them; and they stay in sight. */
  t-film-panel {
    position: sticky;
    inset-block-start: 4.5rem;
    z-index: 3;
  }
  .filmed {
    grid-template-columns: minmax(14rem, 15rem) minmax(0, 1fr) minmax(20rem, 26rem);
  }
  @media (max-width: 80rem) {
    .filmed {
      grid-template-columns: minmax(14rem, 17rem) minmax(0, 1fr);
    }
    .filmed t-film-panel {
      position: static;
      grid-column: 1 / -1;
      order: -1;
    }
  }
  @media (max-width: 60rem) {
    .body,
    .filmed {
      grid-template-columns: minmax(0, 1fr);
    }
  }
  @media (pointer: coarse) {
    .hint {
      display: none;
    }
  }
`;
