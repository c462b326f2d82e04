/** The stretch of time that a chart shows, and how zooming and panning change it. */

import { DAY_US } from "./zone-clock.js";

export interface TimeSpan {
  readonly fromUs: number;
  readonly toUs: number;
}

/** Shortest and longest window (µs): a few samples of a fast signal, and some years. */
export const SHORTEST_US = 10_000;
export const LONGEST_US = 3660 * DAY_US;

export function lengthOf(span: TimeSpan): number {
  return span.toUs - span.fromUs;
}

/** Zoom about a moment that stays where it is. A factor below 1 goes closer. */
export function zoomed(span: TimeSpan, factor: number, aboutUs: number): TimeSpan {
  const length = Math.min(LONGEST_US, Math.max(SHORTEST_US, lengthOf(span) * factor));
  const part = (aboutUs - span.fromUs) / lengthOf(span);
  const fromUs = aboutUs - part * length;
  return { fromUs, toUs: fromUs + length };
}

export function panned(span: TimeSpan, byUs: number): TimeSpan {
  return { fromUs: span.fromUs + byUs, toUs: span.toUs + byUs };
}

/** The same window, moved so that it does not end after `latestUs`. */
export function notAfter(span: TimeSpan, latestUs: number): TimeSpan {
  return span.toUs > latestUs ? panned(span, latestUs - span.toUs) : span;
}

/** Two fingers, each held on a moment: the window that puts them where they are now (0 left, 1 right). */
export function pinched(firstUs: number, secondUs: number, first: number, second: number): TimeSpan | null {
  const apart = second - first;
  const between = secondUs - firstUs;
  if (Math.abs(apart) < 0.01 || between * apart <= 0) return null;
  const length = Math.min(LONGEST_US, Math.max(SHORTEST_US, between / apart));
  const fromUs = firstUs - first * length;
  return { fromUs, toUs: fromUs + length };
}
