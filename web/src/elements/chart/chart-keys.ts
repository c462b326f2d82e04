/** What a key asks of a chart. */

import { lengthOf, panned, zoomed, type TimeSpan } from "../../series/time-window.js";

export type KeyAction =
  | { readonly wish: "cursor"; readonly part: number | null }
  | { readonly wish: "span"; readonly span: TimeSpan }
  | { readonly wish: "reset" };

const STEP = 0.01;
const LEAP = 0.1;

/**
 * On a chart that does not zoom, left and right move the cursor, with shift in leaps. On one that
 * does they move the window, and with shift the cursor; plus and minus zoom about the cursor; page
 * up and down move the window by half. Null: the key is not ours.
 *
 * @param part where the cursor is now (0 left, 1 right), null for nowhere
 */
export function keyAction(key: string, shift: boolean, part: number | null, span: TimeSpan, zoomable: boolean): KeyAction | null {
  if (zoomable && !shift) {
    const wish = windowAction(key, span);
    if (wish !== null) return wish;
  }
  const step = shift && !zoomable ? LEAP : STEP;
  const about = span.fromUs + (part ?? 0.5) * lengthOf(span);
  switch (key) {
    case "ArrowLeft":
      return { wish: "cursor", part: Math.max(0, (part ?? 1 + step) - step) };
    case "ArrowRight":
      return { wish: "cursor", part: Math.min(1, (part ?? -step) + step) };
    case "Home":
      return zoomable && !shift ? null : { wish: "cursor", part: 0 };
    case "End":
      return zoomable && !shift ? null : { wish: "cursor", part: 1 };
    case "Escape":
      return part === null ? null : { wish: "cursor", part: null };
  }
  if (!zoomable) return null;
  switch (key) {
    case "+":
    case "=":
      return { wish: "span", span: zoomed(span, 0.5, about) };
    case "-":
      return { wish: "span", span: zoomed(span, 2, about) };
    case "0":
      return { wish: "reset" };
    default:
      return null;
  }
}

function windowAction(key: string, span: TimeSpan): KeyAction | null {
  const by = { ArrowLeft: -LEAP, ArrowRight: LEAP, PageUp: -0.5, PageDown: 0.5 }[key];
  return by === undefined ? null : { wish: "span", span: panned(span, by * lengthOf(span)) };
}
