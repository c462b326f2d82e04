/**
 * Layout of the actuate page. On a desk: camera and commands left, STOP, hands and map right; where
 * there is room, map and scene stand left of the camera. Narrow: one column under the thumb, where
 * the right column dissolves and `order` sorts what was in it.
 */

import { css } from "lit";

export const layout = css`
  :host {
    display: block;
  }
  .page {
    display: grid;
    gap: var(--t-space-3);
    /* The window's height is scarce here. */
    margin-block-start: calc(-1 * var(--t-space-2));
  }
  .cockpit {
    display: grid;
    grid-template: "camera right" auto "camera around" minmax(18rem, 1fr) "commands commands" auto / minmax(0, 1fr) minmax(22rem, 27rem);
    gap: var(--t-space-4);
    align-items: start;
  }
  .cockpit > .commands {
    grid-area: commands;
  }
  .top {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    justify-content: space-between;
    gap: var(--t-space-2) var(--t-space-4);
  }
  .right {
    grid-area: right;
    display: flex;
    flex-direction: column;
    gap: var(--t-space-4);
    min-inline-size: 0;
  }
  .right > * {
    flex: none;
  }
  .around {
    grid-area: around;
    --t-map-height: 15rem;
  }
  /* The note that this is no emergency stop: read once, so it makes way for the hands. */
  .right .calm {
    order: 1;
  }
  .hands {
    --t-pad-size: 10.75rem;
    --t-arrows-size: 9.75rem;
  }
  .plain {
    position: absolute;
    clip-path: inset(50%);
  }
  .stop {
    position: sticky;
    inset-block-start: calc(var(--t-header, 3.75rem) + var(--t-space-2));
    z-index: 10;
  }
  .top h1 {
    font-size: var(--t-size-l);
  }
  .camera {
    grid-area: camera;
    inline-size: 100%;
    max-inline-size: calc((100dvh - var(--t-header, 3.75rem) - 2rem) * 4 / 3);
    margin-inline: auto;
  }
  /* Room for all: what lies around the vehicle, what it sees, and the hands. */
  @media (min-width: 110rem) {
    .cockpit {
      grid-template: "around camera right" auto "commands commands commands" auto / minmax(24rem, 34rem) minmax(0, 1fr) minmax(24rem, 30rem);
    }
    .around {
      align-self: stretch;
      --t-map-height: 100%;
      --t-around-height: 18rem;
    }
  }
  .page:fullscreen {
    overflow: auto;
    padding: var(--t-space-3);
    background: var(--t-bg);
  }
  .page.full .stop {
    inset-block-start: 0;
  }
  .page.full .camera {
    max-inline-size: calc((100dvh - 2rem) * 4 / 3);
  }
  .page.full :is(.top, .commands) {
    display: none;
  }

  /* A phone on its side: the camera stays left while the hands scroll, commands come below. */
  @media (max-width: 60rem) and (orientation: landscape) {
    .cockpit {
      grid-template: "camera right" auto "around around" auto "commands commands" auto / minmax(0, 1fr) 21rem;
      gap: var(--t-space-2) var(--t-space-3);
    }
    .hands {
      padding: var(--t-space-2) var(--t-space-3);
      --t-pad-size: 9rem;
      --t-arrows-size: 9rem;
    }
    .camera {
      position: sticky;
      inset-block-start: calc(var(--t-header, 3.75rem) + var(--t-space-2));
      max-inline-size: calc((100dvh - 4.5rem) * 4 / 3);
    }
    .right {
      gap: var(--t-space-2);
    }
    .page.full :is(.camera, .stop) {
      inset-block-start: 0;
    }
  }

  @media (max-width: 52rem) and (orientation: portrait) {
    .cockpit {
      display: flex;
      flex-direction: column;
      align-items: stretch;
      gap: var(--t-space-3);
    }
    .right {
      display: contents;
    }
    .camera {
      order: 1;
      max-inline-size: none;
    }
    /* Stays in sight wherever the page is scrolled to: at the lower edge until its own place
       comes, at the upper edge after that. */
    .stop {
      order: 2;
      inset-block: calc(var(--t-header, 3.75rem) + var(--t-space-2)) calc(4.75rem + env(safe-area-inset-bottom));
    }
    .stopped {
      order: 3;
    }
    .hands {
      order: 4;
      --t-pad-size: 1.25fr;
      --t-arrows-size: 1fr;
    }
    .right .calm {
      order: 5;
    }
    .around {
      order: 6;
      --t-map-height: 20rem;
      --t-around-height: 20rem;
    }
    .commands {
      order: 7;
    }
  }
`;
