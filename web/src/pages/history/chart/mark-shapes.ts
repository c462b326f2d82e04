/** The shape of each kind of mark, 16 by 16: told apart without colour. */

import { svg, type SVGTemplateResult } from "lit";
import type { MarkKind } from "./event-marks.js";

const SHAPES: Readonly<Record<MarkKind, string>> = {
  alarm: "M8 1.5 15 14.5H1z",
  stop: "M5.3 1.5h5.4l3.8 3.8v5.4l-3.8 3.8H5.3l-3.8-3.8V5.3z",
  command: "M8 1 15 8 8 15 1 8z",
  driving: "M8 1.5a6.5 6.5 0 1 1 0 13a6.5 6.5 0 0 1 0-13z",
  anomaly: "M8 1 9.8 6.2 15 8 9.8 9.8 8 15 6.2 9.8 1 8 6.2 6.2z",
  sighting: "M1 8C3 4.5 5.3 3 8 3s5 1.5 7 5c-2 3.5-4.3 5-7 5s-5-1.5-7-5z",
  recording: "M1 3.5h9.5v3L15 4v8l-4.5-2.5v3H1z",
  note: "M2 2h12v8H8.5L5 14v-4H2z",
  link: "M2 2h12v12H2z",
  other: "M8 4.5a3.5 3.5 0 1 1 0 7a3.5 3.5 0 0 1 0-7z",
};

/** The inside of an `<svg viewBox="0 0 16 16">`. */
export function renderMarkShape(kind: MarkKind): SVGTemplateResult {
  return svg`<path d=${SHAPES[kind]} fill="currentColor"></path>`;
}
