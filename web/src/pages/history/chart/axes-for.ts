/** How many value axes a chart of a width has room for. */

const PLAIN = 60;
const NARROW = 46;
/** Below this (CSS pixels) four axes would leave no room for lines. */
const WIDE = 700;

/**
 * @param joined several units may share a chart
 * @param width of all charts (CSS pixels)
 * @returns units for each chart at most, and the width of one axis (CSS pixels)
 */
export function axesFor(joined: boolean, width: number): { readonly most: number; readonly axisWidth: number } {
  const wide = width >= WIDE;
  return { most: joined ? (wide ? 4 : 2) : 1, axisWidth: joined && !wide ? NARROW : PLAIN };
}
