/** How a camera's film looks, and what stands over it. */

import { css } from "lit";

export const filmViewStyle = css`
  :host {
    container-type: inline-size;
  }
  video[hidden],
  canvas[hidden] {
    display: none;
  }
  .veil {
    padding-block-end: var(--t-space-6);
    background: var(--t-raised);
    color: var(--t-text);
    overflow: auto;
  }
  .veil a {
    color: var(--t-accent);
    font-weight: var(--t-weight-strong);
  }
  .ways {
    display: flex;
    flex-wrap: wrap;
    justify-content: center;
    gap: var(--t-space-2);
  }
  .get {
    position: absolute;
    inset-block-start: var(--t-space-2);
    inset-inline-end: var(--t-space-2);
  }
  .badge {
    display: block;
    position: absolute;
    inset-block-end: var(--t-space-2);
    inset-inline-start: var(--t-space-2);
    max-inline-size: calc(100% - 2 * var(--t-space-2));
    pointer-events: none;
  }
  /* Several side by side on a phone: the picture comes first, full screen has the rest. */
  @container (inline-size < 15rem) {
    .get,
    .badge time,
    .veil p {
      display: none;
    }
    .badge {
      inset: auto auto 0 0;
      border-width: 0;
      border-radius: 0 var(--t-radius-s) 0 0;
    }
    .veil {
      padding: var(--t-space-1);
      padding-block-end: var(--t-space-5);
      gap: 0;
    }
    .veil h3 {
      font-size: var(--t-size-s);
    }
    .veil t-button {
      font-size: var(--t-size-s);
    }
  }
`;
