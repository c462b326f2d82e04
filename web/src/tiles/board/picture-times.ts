/**
 * When the pictures of a board's cameras were taken, and by which of them somebody drives: the speed of
 * who drives by a picture falls with its age, also where camera and hands are two tiles.
 */

import { Store } from "../../state/store.js";

export class PictureTimes extends Store {
  private readonly taken = new Map<string, number | null>();
  private driven = "";

  /** @param takenAt on this page's clock (ms); null for none */
  reportPicture(stream: string, takenAt: number | null): void {
    this.taken.set(stream, takenAt);
    this.notifyWatchers();
  }

  takenAt(stream: string): number | null {
    return this.taken.get(stream) ?? null;
  }

  /** @param stream empty when nobody drives */
  setDriven(stream: string): void {
    if (stream === this.driven) return;
    this.driven = stream;
    this.notifyWatchers();
  }

  isDriven(stream: string): boolean {
    return stream !== "" && stream === this.driven;
  }
}
