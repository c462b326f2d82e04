/** Of the pictures that come, draws the newest; each one that came is paid for once. */

import type { CameraPicture } from "../../generated/wire.js";

export interface JpegDrawing {
  /** Throws what cannot be decoded. */
  readonly decode: (shot: CameraPicture) => Promise<ImageBitmap>;
  readonly draw: (bitmap: ImageBitmap, shot: CameraPicture) => void;
  readonly failed: (shot: CameraPicture) => void;
}

interface WaitingJpeg {
  readonly shot: CameraPicture;
  readonly shown: () => void;
}

/** One decode at a time. A picture that a newer one overtakes meanwhile is never drawn. */
export class JpegPlayer {
  private busy = false;
  private next: WaitingJpeg | null = null;
  private closed = false;

  constructor(private readonly drawing: JpegDrawing) {}

  receivePicture(shot: CameraPicture, shown: () => void): void {
    if (this.closed) return;
    this.next?.shown();
    this.next = { shot, shown };
    if (!this.busy) void this.drawLoop();
  }

  close(): void {
    this.closed = true;
    this.next = null;
  }

  private async drawLoop(): Promise<void> {
    this.busy = true;
    while (this.next) {
      const { shot, shown } = this.next;
      this.next = null;
      try {
        const bitmap = await this.drawing.decode(shot);
        if (this.isClosed()) bitmap.close();
        else this.drawing.draw(bitmap, shot);
      } catch {
        if (!this.isClosed()) this.drawing.failed(shot);
      }
      // Paid also when it could not be drawn: one spoilt picture must not stop the stream.
      shown();
    }
    this.busy = false;
  }

  // Asked anew after each wait: it may have been closed meanwhile.
  private isClosed(): boolean {
    return this.closed;
  }
}
