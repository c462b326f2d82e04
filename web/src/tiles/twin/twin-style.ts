/** How a twin's tile looks. */

import { css } from "lit";
import { quietText, raisedBox } from "../../elements/base/base-style.js";

export const twinStyle = css`
  :host {
    display: grid;
    grid-template-columns: minmax(0, 1fr);
    gap: var(--t-space-4);
    min-inline-size: 0;
  }
  section {
    display: grid;
    align-content: start;
    grid-template-columns: minmax(0, 1fr);
    gap: var(--t-space-3);
    padding: var(--t-space-4);
    ${raisedBox}
    min-inline-size: 0;
  }
  .values {
    display: grid;
    grid-template-columns: repeat(auto-fill, minmax(min(11rem, 100%), 1fr));
    gap: var(--t-space-3);
  }
  .columns {
    display: grid;
    grid-template-columns: repeat(auto-fit, minmax(min(22rem, 100%), 1fr));
    align-items: start;
    gap: var(--t-space-4);
  }
  /* As large as on the page that drives the robot, where there is room for both. */
  @media (min-width: 52rem) {
    .hands {
      --t-pad-size: 10.75rem;
      --t-arrows-size: 9.75rem;
    }
  }
  .switch {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    gap: var(--t-space-2) var(--t-space-4);
    padding: var(--t-space-2) var(--t-space-3);
    border: 2px solid var(--t-line);
    border-radius: var(--t-radius-s);
  }
  /* Whoever looks up must see at once that a robot moves. */
  .switch.live {
    border-color: var(--t-warn);
  }
  label {
    display: inline-flex;
    align-items: center;
    gap: var(--t-space-2);
    min-block-size: var(--t-touch);
    font-weight: var(--t-weight-strong);
  }
  input {
    inline-size: 1.5rem;
    block-size: 1.5rem;
    accent-color: var(--t-accent);
  }
  .muted {
    ${quietText}
  }
  .trouble {
    color: var(--t-warn);
    font-weight: var(--t-weight-strong);
  }
  .trouble:empty {
    display: none;
  }
  .deeds {
    display: flex;
    flex-wrap: wrap;
    gap: var(--t-space-2);
  }
  ul {
    margin: 0;
    padding-inline-start: var(--t-space-4);
  }
`;
