/**
 * Whether a decoded picture shows anything: a decoder that lost its thread, or an encoder without
 * bits, gives an even grey area, which is no picture and must not look live.
 */

/** The least difference of brightness (0 to 255) in a picture that shows something. */
export const LEAST_CONTRAST = 6;
/** Looked at this often (ms); each look reads a few pixels back. */
export const LOOK_EVERY_MS = 200;
const WIDTH = 32;
const HEIGHT = 24;

/** @param rgba - pixels as a canvas gives them */
export function showsSomething(rgba: Uint8ClampedArray): boolean {
  let least = 255;
  let most = 0;
  for (let at = 0; at + 2 < rgba.length; at += 4) {
    const light = ((rgba[at] ?? 0) * 77 + (rgba[at + 1] ?? 0) * 150 + (rgba[at + 2] ?? 0) * 29) >> 8;
    least = Math.min(least, light);
    most = Math.max(most, light);
    if (most - least >= LEAST_CONTRAST) return true;
  }
  return false;
}

/** Judges pictures now and then; in between the last judgement holds. */
export class ContrastCheck {
  private context: CanvasRenderingContext2D | null = null;
  private judgedAt = Number.NEGATIVE_INFINITY;
  private good = true;

  /** @param now - monotonic (ms) */
  showsPicture(picture: CanvasImageSource, now: number): boolean {
    // What was empty is looked at again at once, so that a good picture is live without delay.
    if (this.good && now - this.judgedAt < LOOK_EVERY_MS) return true;
    const context = (this.context ??= smallCanvas());
    if (context === null) return true;
    context.drawImage(picture, 0, 0, WIDTH, HEIGHT);
    this.good = showsSomething(context.getImageData(0, 0, WIDTH, HEIGHT).data);
    this.judgedAt = now;
    return this.good;
  }
}

function smallCanvas(): CanvasRenderingContext2D | null {
  const canvas = document.createElement("canvas");
  canvas.width = WIDTH;
  canvas.height = HEIGHT;
  return canvas.getContext("2d", { willReadFrequently: true });
}
