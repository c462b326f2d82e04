/** Where the pictures of described cameras come from: a scene shows them, and does not know whether they are live. Pure. */

import type { ScenePicture } from "./scene-model.js";

export interface PictureListener {
  /** `key` is what the picture was asked for by; null: what was shown is not true any more. */
  readonly onPicture: (key: string, picture: ScenePicture | null) => void;
  /** Why no picture comes; empty when nothing is wrong. */
  readonly onTrouble: (key: string, why: string) => void;
  /** There is none now, nor will be: pictures from elsewhere may stand in its place. */
  readonly onMissing: (key: string, missing: boolean) => void;
}

export interface StreamPictures {
  /** Shows the pictures of these streams (`device/stream`), each by its key, and no others. */
  followStreams(wanted: ReadonlyMap<string, string>): void;
  close(): void;
}

export type OpenPictures = (listener: PictureListener) => StreamPictures;
