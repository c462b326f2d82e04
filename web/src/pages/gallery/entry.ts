/** What the gallery shows: each element in each of its states. */

import type { TemplateResult } from "lit";

export interface GalleryState {
  readonly name: string;
  readonly show: () => TemplateResult;
}

export interface GalleryEntry {
  /** The element's tag; of a section of something else, a name that is unique. */
  readonly tag: string;
  /** What it is called; without it its tag. */
  readonly title?: string;
  readonly states: readonly GalleryState[];
  /** Takes the whole width. */
  readonly wide?: boolean;
  /** A state is at least so wide where there is room (rem). */
  readonly least?: number;
}
