/** What every element's style starts from. */

import { css } from "lit";

/* Declarations that stand in many rules. */

/** The edge and ground of what stands on a page as a thing of its own. */
export const panelBox = css`
  border: 1px solid var(--t-line);
  border-radius: var(--t-radius);
  background: var(--t-surface);
`;

/** The same, lifted off the page. */
export const raisedBox = css`
  ${panelBox}
  box-shadow: var(--t-shadow);
`;

/** A list without its marks. */
export const plainList = css`
  margin: 0;
  padding: 0;
  list-style: none;
`;

/** What is said beside the matter. */
export const quietText = css`
  color: var(--t-muted);
  font-size: var(--t-size-s);
`;

export const base = css`
  /* Said to each, not inherited: what a details element holds inherits from the browser's own tree. */
  :host,
  *,
  *::before,
  *::after {
    box-sizing: border-box;
  }
  :host([hidden]),
  [hidden] {
    display: none !important;
  }
  ::selection {
    background: var(--t-accent);
    color: var(--t-on-accent);
  }
  :focus-visible {
    outline: 3px solid var(--t-accent);
    outline-offset: 2px;
  }
  h1,
  h2,
  h3,
  p {
    margin: 0;
    text-wrap: pretty;
  }
  h1 {
    font-size: var(--t-size-xl);
    line-height: 1.2;
    font-weight: var(--t-weight-strong);
    letter-spacing: -0.01em;
  }
  h2 {
    font-size: var(--t-size-l);
    line-height: 1.25;
    font-weight: var(--t-weight-strong);
  }
  h3 {
    font-size: var(--t-size-m);
    font-weight: var(--t-weight-strong);
  }
  a {
    color: var(--t-accent);
    text-underline-offset: 0.2em;
  }
  code {
    font-family: var(--t-mono);
    font-size: var(--t-size-s);
  }
  .muted {
    color: var(--t-muted);
  }
  .small {
    font-size: var(--t-size-s);
  }
  .visually-hidden {
    position: absolute;
    width: 1px;
    height: 1px;
    margin: -1px;
    overflow: hidden;
    clip-path: inset(50%);
    white-space: nowrap;
  }
  @media (prefers-reduced-motion: reduce) {
    *,
    *::before,
    *::after {
      animation-duration: 0.01ms !important;
      animation-iteration-count: 1 !important;
      transition-duration: 0.01ms !important;
    }
  }
`;
