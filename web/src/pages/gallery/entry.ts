/** What the gallery shows: each element in each of its states. */

import type { TemplateResult } from "lit";

export interface GalleryState {
  readonly name: string;
  readonly show: () => TemplateResult;
}

export interface GalleryEntry {
  /** The element's tag. */
  readonly tag: string;
  readonly states: readonly GalleryState[];
  /** Takes the whole width. */
  readonly wide?: boolean;
}
