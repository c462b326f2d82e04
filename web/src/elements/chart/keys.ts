/** What a key asks of a chart. */

import { lengthOf, pan, zoom, type Span } from "../../series/window.js";

export type KeyWish =
  | { readonly wish: "cursor"; readonly part: number | null }
  | { readonly wish: "span"; readonly span: Span }
  | { readonly wish: "reset" };

const STEP = 0.01;
const LEAP = 0.1;

/**
 * Left and right move the cursor, with shift in leaps; plus and minus zoom about it; page up and
 * down move the window. Null: the key is not ours.
 *
 * @param part where the cursor is now (0 left, 1 right), null for nowhere
 */
export function keyWish(key: string, shift: boolean, part: number | null, span: Span, zoomable: boolean): KeyWish | null {
  const step = shift ? LEAP : STEP;
  const about = span.fromUs + (part ?? 0.5) * lengthOf(span);
  switch (key) {
    case "ArrowLeft":
      return { wish: "cursor", part: Math.max(0, (part ?? 1 + step) - step) };
    case "ArrowRight":
      return { wish: "cursor", part: Math.min(1, (part ?? -step) + step) };
    case "Home":
      return { wish: "cursor", part: 0 };
    case "End":
      return { wish: "cursor", part: 1 };
    case "Escape":
      return part === null ? null : { wish: "cursor", part: null };
  }
  if (!zoomable) return null;
  switch (key) {
    case "+":
    case "=":
      return { wish: "span", span: zoom(span, 0.5, about) };
    case "-":
      return { wish: "span", span: zoom(span, 2, about) };
    case "PageUp":
      return { wish: "span", span: pan(span, -lengthOf(span) / 2) };
    case "PageDown":
      return { wish: "span", span: pan(span, lengthOf(span) / 2) };
    case "0":
      return { wish: "reset" };
    default:
      return null;
  }
}
