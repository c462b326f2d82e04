/** How the scene looks. */

import { css } from "lit";
import { quietText, raisedBox } from "../base/base-style.js";

export const sceneStyle = css`
  :host {
    display: grid;
    grid-template-columns: minmax(0, 1fr) minmax(14rem, 19rem);
    gap: var(--t-space-3);
    min-inline-size: 0;
  }
  :host([bare]) {
    grid-template-columns: minmax(0, 1fr);
    grid-template-rows: minmax(0, 1fr);
    min-block-size: 0;
  }
  t-problem {
    align-self: start;
  }
  .view {
    position: relative;
    min-block-size: var(--t-scene-least, 22rem);
    block-size: var(--t-scene-height, 70vh);
    ${raisedBox}
    border-radius: 0;
    box-shadow: none;
  }
  /*
   * Round corners of a picture that moves are cut out of each frame anew: in software a sixth of its cost. So four small
   * pieces of what lies around it cover its corners, with the edge on them.
   */
  .corner {
    --at: calc(var(--t-radius) - 0.5px);
    position: absolute;
    inline-size: var(--t-radius);
    block-size: var(--t-radius);
    background: radial-gradient(
      circle at var(--middle),
      transparent calc(var(--at) - 1px),
      var(--t-line) calc(var(--at) - 0.5px) calc(var(--at) + 0.25px),
      var(--t-scene-around, var(--t-bg)) calc(var(--at) + 0.75px)
    );
    pointer-events: none;
  }
  .corner:is(.nw, .ne) {
    inset-block-start: -1px;
  }
  .corner:is(.sw, .se) {
    inset-block-end: -1px;
  }
  .corner:is(.nw, .sw) {
    inset-inline-start: -1px;
  }
  .corner:is(.ne, .se) {
    inset-inline-end: -1px;
  }
  .nw {
    --middle: bottom right;
  }
  .ne {
    --middle: bottom left;
  }
  .sw {
    --middle: top right;
  }
  .se {
    --middle: top left;
  }
  canvas {
    position: absolute;
    inset: 0;
    inline-size: 100%;
    block-size: 100%;
    touch-action: none;
  }
  canvas:focus-visible {
    outline-offset: -3px;
  }
  .tools {
    position: absolute;
    inset-block-start: var(--t-space-2);
    inset-inline: var(--t-space-2);
    display: flex;
    flex-wrap: wrap;
    gap: var(--t-space-2);
    pointer-events: none;
  }
  .tools > * {
    pointer-events: auto;
  }
  .notes {
    position: absolute;
    inset-block-end: var(--t-space-2);
    inset-inline: var(--t-space-2);
    display: grid;
    justify-items: start;
    gap: var(--t-space-1);
    pointer-events: none;
  }
  .note {
    padding: var(--t-space-1) var(--t-space-3);
    background: var(--t-surface);
    border: 1px solid var(--t-line);
    border-radius: var(--t-radius-s);
    font-size: var(--t-size-s);
    font-variant-numeric: tabular-nums;
  }
  .note.old {
    border-color: var(--t-warn);
    color: var(--t-warn);
  }
  .side {
    display: grid;
    align-content: start;
    gap: var(--t-space-3);
    padding: var(--t-space-4);
    ${raisedBox}
    min-inline-size: 0;
    max-block-size: var(--t-scene-height, 70vh);
    overflow: auto;
  }
  fieldset {
    margin: 0;
    padding: 0;
    border: 0;
    min-inline-size: 0;
  }
  legend {
    padding: 0;
    font-weight: var(--t-weight-strong);
  }
  label.row {
    display: grid;
    grid-template-columns: auto minmax(0, 1fr) auto;
    align-items: center;
    gap: var(--t-space-2);
    min-block-size: var(--t-touch);
    cursor: pointer;
  }
  label.row input {
    inline-size: 1.25rem;
    block-size: 1.25rem;
    accent-color: var(--t-accent);
  }
  label.field {
    display: grid;
    gap: var(--t-space-1);
    font-weight: var(--t-weight-strong);
  }
  .topic {
    font-family: var(--t-mono);
    font-size: var(--t-size-s);
    overflow-wrap: anywhere;
  }
  .age,
  .why {
    ${quietText}
    font-variant-numeric: tabular-nums;
  }
  .why {
    grid-column: 2 / -1;
    color: var(--t-warn);
  }
  .frames {
    margin: 0;
    padding: 0;
    list-style: none;
  }
  .frames li {
    display: flex;
    justify-content: space-between;
    gap: var(--t-space-2);
    font-size: var(--t-size-s);
  }
  .frames .old {
    color: var(--t-warn);
  }
  summary {
    min-block-size: var(--t-touch);
    align-content: center;
    font-weight: var(--t-weight-strong);
    cursor: pointer;
  }
  @media (max-width: 60rem) {
    :host {
      grid-template-columns: minmax(0, 1fr);
    }
    .view {
      block-size: var(--t-scene-height, 60vh);
    }
    .side {
      max-block-size: none;
    }
  }
`;
