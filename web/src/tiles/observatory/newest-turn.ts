/** When a camera's newest picture in the archive is asked for anew. Pure. */

/** The archive is asked for something newer this often (ms): others take pictures, too. */
const AGAIN_MS = 15_000;
/** A picture needs a moment to come from the camera into the archive (ms). */
const COMES_MS = 4000;

/** Another word for each time that it is to be asked for: now and then, and once after an exposure has ended (0: none). */
export function newestTurn(nowMs: number, endedMs: number): string {
  const late = endedMs > 0 && nowMs > endedMs + COMES_MS ? endedMs : 0;
  return `${String(Math.floor(nowMs / AGAIN_MS))} ${String(late)}`;
}
