/** The look of a picture's frame, and of what lies on a picture: keys, a badge, what stands there instead of it, the tint. */

import { css } from "lit";

/** Of an element that is one recorded picture or film. */
export const pictureFrame = css`
  :host {
    display: grid;
    position: relative;
    overflow: hidden;
    border: 1px solid var(--t-line);
    border-radius: var(--t-radius);
    background: #000;
    aspect-ratio: 4 / 3;
    min-inline-size: 0;
  }
  video,
  canvas,
  img {
    position: absolute;
    inset: 0;
    inline-size: 100%;
    block-size: 100%;
    object-fit: contain;
    filter: var(--t-picture-filter, none);
  }
`;

export const onPicture = css`
  /* Multiplied with the picture: a red tint leaves nothing but red. Only there where a theme
     asks for it: blending costs a pass over the whole picture, 30 times a second. */
  .tint {
    display: var(--t-picture-tinted, none);
    position: absolute;
    inset: 0;
    background: var(--t-picture-tint);
    mix-blend-mode: multiply;
    pointer-events: none;
  }
  .veil {
    position: absolute;
    inset: 0;
    display: grid;
    place-content: center;
    justify-items: center;
    gap: var(--t-space-2);
    padding: var(--t-space-4);
    text-align: center;
  }
  .veil p {
    max-inline-size: 34ch;
    color: var(--t-muted);
  }
  .badge,
  .counts,
  .key {
    border: 1px solid var(--t-line);
    border-radius: var(--t-radius-s);
    background: var(--t-surface);
    color: var(--t-text);
    font-size: var(--t-size-s);
  }
  .badge,
  .counts {
    display: inline-flex;
    align-items: center;
    gap: var(--t-space-2);
    padding: 0.2rem var(--t-space-2);
    font-variant-numeric: tabular-nums;
  }
  .key {
    pointer-events: auto;
    display: inline-flex;
    align-items: center;
    justify-content: center;
    gap: var(--t-space-2);
    min-inline-size: var(--t-touch);
    block-size: var(--t-touch);
    padding: 0;
    font-family: inherit;
    font-weight: var(--t-weight-strong);
    cursor: pointer;
  }
  .key.worded {
    padding-inline: var(--t-space-2);
  }
  .key svg {
    inline-size: 1.4rem;
    block-size: 1.4rem;
  }
`;
