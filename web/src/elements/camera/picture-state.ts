/** What a camera's picture is at a moment, for who looks at it. Pure. */

/** Older than this it is not live (safety rule 12; ms). */
const LIVE_MS = 500;

export interface PictureFacts {
  /** Pictures are single exposures: none of them is live, and none is late. */
  readonly still: boolean;
  readonly drawn: boolean;
  readonly isOpen: boolean;
  /** NaN where it is not known. */
  readonly ageMs: number;
}

/** "exposure": a finished one, which is as it should be; "old": what was live and is no more; "none": nothing yet. */
export function pictureState({ still, drawn, isOpen, ageMs }: PictureFacts): "none" | "live" | "exposure" | "old" {
  if (!drawn) return "none";
  if (still) return "exposure";
  return isOpen && ageMs <= LIVE_MS ? "live" : "old";
}
