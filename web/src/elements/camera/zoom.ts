/** Looking closer at a part of a picture: pure sums, in parts of the view's width and height. */

/** The picture is `scale` times as large and its left upper corner lies at `x`, `y` (0 or less). */
export interface Zoom {
  readonly scale: number;
  readonly x: number;
  readonly y: number;
}

export const WHOLE: Zoom = { scale: 1, x: 0, y: 0 };
export const MOST_ZOOM = 8;

/** Nothing but picture stays in view. */
function clampedZoom(zoom: Zoom): Zoom {
  const scale = Math.min(MOST_ZOOM, Math.max(1, zoom.scale));
  const most = 1 - scale;
  // `+ 0` makes no negative zero.
  return { scale, x: Math.min(0, Math.max(most, zoom.x)) + 0, y: Math.min(0, Math.max(most, zoom.y)) + 0 };
}

/** Makes it larger by a factor; what is at `atX`, `atY` stays there. */
export function zoomedAt(zoom: Zoom, factor: number, atX: number, atY: number): Zoom {
  const scale = Math.min(MOST_ZOOM, Math.max(1, zoom.scale * factor));
  const by = scale / zoom.scale;
  return clampedZoom({ scale, x: atX - (atX - zoom.x) * by, y: atY - (atY - zoom.y) * by });
}

/** Moves it. */
export function movedZoom(zoom: Zoom, dx: number, dy: number): Zoom {
  return clampedZoom({ ...zoom, x: zoom.x + dx, y: zoom.y + dy });
}

/** How much larger one notch of a wheel, or a pinch on a touch pad, makes it. */
export function wheelFactor(delta: number): number {
  return Math.exp(-Math.max(-100, Math.min(100, delta)) / 300);
}
