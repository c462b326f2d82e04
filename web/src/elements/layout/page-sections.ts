/** The look of pages that hold lists and forms: sheets below each other, facts in rows. */

import { css } from "lit";
import { raisedBox, plainList, quietText } from "../base/base-style.js";

export const sheets = css`
  :host {
    display: grid;
    grid-template-columns: minmax(0, 1fr);
    align-content: start;
    gap: var(--t-space-4);
    min-inline-size: 0;
  }
  .head {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    justify-content: space-between;
    gap: var(--t-space-2) var(--t-space-4);
  }
  .head > div:not(.actions, .tools) {
    display: grid;
    gap: var(--t-space-1);
  }
  .sheet {
    display: grid;
    gap: var(--t-space-4);
    padding: var(--t-space-5);
    ${raisedBox}
    min-inline-size: 0;
  }
  .fields {
    display: grid;
    gap: var(--t-space-4);
    max-inline-size: 26rem;
  }
  .actions {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    gap: var(--t-space-2);
  }
  /* A link among buttons is as easy to hit as they are. */
  .actions > a {
    display: inline-flex;
    align-items: center;
    min-block-size: var(--t-touch);
    padding-inline: var(--t-space-2);
    font-weight: var(--t-weight-strong);
  }
  summary {
    min-block-size: var(--t-touch);
    align-content: center;
    font-weight: var(--t-weight-strong);
    cursor: pointer;
  }
  /* A roof or telescope that does not close or park by itself. */
  .unguarded {
    display: flex;
    gap: var(--t-space-2);
    max-inline-size: 60rem;
  }
  .unguarded t-icon {
    flex: none;
    color: var(--t-warn);
  }
  .rows {
    display: grid;
    gap: 0;
    ${plainList}
  }
  .rows > li {
    display: grid;
    grid-template-columns: minmax(0, 1fr) auto;
    align-items: center;
    gap: var(--t-space-2) var(--t-space-4);
    padding-block: var(--t-space-3);
    border-block-start: 1px solid var(--t-line);
    /* The name of a file is one long word. */
    overflow-wrap: anywhere;
  }
  .rows > li:first-child {
    border-block-start: 0;
    padding-block-start: 0;
  }
  .rows > li:last-child {
    padding-block-end: 0;
  }
  .name {
    font-weight: var(--t-weight-strong);
    overflow-wrap: anywhere;
  }
  .facts {
    display: flex;
    flex-wrap: wrap;
    gap: 0 var(--t-space-4);
    ${quietText}
    overflow-wrap: anywhere;
  }
  /* Links that lead on. */
  .ways {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    gap: 0 var(--t-space-4);
  }
  .ways a {
    display: inline-flex;
    align-items: center;
    min-block-size: var(--t-touch);
    font-weight: var(--t-weight-strong);
  }
  /* Where an endless list goes on. */
  .end {
    min-block-size: 2rem;
    color: var(--t-muted);
  }
  .chip {
    display: inline-block;
    padding: 0 0.5em;
    border: 1px solid var(--t-line);
    border-radius: 1em;
    background: var(--t-raised);
    color: var(--t-text);
    font-size: var(--t-size-s);
    font-weight: var(--t-weight-strong);
    white-space: nowrap;
  }
  .said {
    color: var(--t-ok);
    font-weight: var(--t-weight-strong);
  }
  @media (max-width: 45rem) {
    .sheet {
      padding: var(--t-space-4);
    }
    .rows > li {
      grid-template-columns: minmax(0, 1fr);
    }
  }
`;
