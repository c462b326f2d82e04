/** The look of the review: the days in a row, and beside what is shown all of the day. */

import { css } from "lit";
import { plainList, quietText } from "../../elements/base/base-style.js";

export const reviewStyle = css`
  .days {
    display: flex;
    gap: var(--t-space-2);
    overflow-x: auto;
    padding-block-end: var(--t-space-1);
  }
  .days a {
    display: grid;
    flex: none;
    align-content: center;
    min-block-size: var(--t-touch);
    padding: var(--t-space-1) var(--t-space-3);
    border: 1px solid var(--t-line);
    border-radius: var(--t-radius-s);
    background: var(--t-surface);
    color: var(--t-text);
    font-variant-numeric: tabular-nums;
    text-decoration: none;
  }
  .days a[aria-current="date"] {
    border-color: var(--t-accent);
    box-shadow: inset 0 0 0 1px var(--t-accent);
    font-weight: var(--t-weight-strong);
  }
  .many {
    ${quietText}
  }
  .desk {
    display: grid;
    grid-template-columns: minmax(0, 1fr);
    gap: var(--t-space-4);
  }
  .stage {
    display: grid;
    align-content: start;
    gap: var(--t-space-3);
    min-inline-size: 0;
  }
  /* What can be done with it stays in view. */
  .stage t-sighting-clip {
    inline-size: 100%;
    max-block-size: max(16rem, 50vh);
  }
  .strip {
    display: grid;
    grid-template-columns: repeat(auto-fill, minmax(9rem, 1fr));
    gap: var(--t-space-2);
    ${plainList}
  }
  .thumb {
    display: grid;
    inline-size: 100%;
    padding: var(--t-space-1);
    border: 1px solid var(--t-line);
    border-radius: var(--t-radius-s);
    background: var(--t-surface);
    color: var(--t-text);
    font: inherit;
    text-align: start;
    cursor: pointer;
  }
  .thumb[aria-current="true"] {
    border-color: var(--t-accent);
    box-shadow: inset 0 0 0 2px var(--t-accent);
  }
  .thumb .picture {
    display: grid;
    place-content: center;
    aspect-ratio: 4 / 3;
    overflow: hidden;
    border-radius: var(--t-radius-s);
    background: var(--t-raised);
  }
  .thumb img {
    inline-size: 100%;
    block-size: 100%;
    object-fit: contain;
    filter: var(--t-still-filter, none);
  }
  .thumb.seen .picture {
    opacity: 0.55;
  }
  .what {
    font-weight: var(--t-weight-strong);
    overflow-wrap: anywhere;
  }
  .when,
  .keys {
    ${quietText}
    font-variant-numeric: tabular-nums;
  }
  kbd {
    padding: 0 0.4em;
    border: 1px solid var(--t-line);
    border-radius: 3px;
    font: inherit;
  }
  @media (min-width: 62rem) {
    .desk {
      grid-template-columns: minmax(0, 3fr) minmax(0, 2fr);
      align-items: start;
    }
    .stage {
      position: sticky;
      inset-block-start: 4.5rem;
    }
  }
  /* Without a keyboard the keys are of no use. */
  @media (pointer: coarse) {
    .keys {
      display: none;
    }
  }
`;
