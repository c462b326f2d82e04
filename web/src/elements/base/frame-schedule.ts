/** Draws with the next frame of the browser, once for all that has changed; after its end no more. */
export class FrameSchedule {
  private request = 0;

  constructor(private readonly paint: () => void) {}

  readonly schedule = (): void => {
    if (this.request !== 0) return;
    this.request = requestAnimationFrame(() => {
      this.request = 0;
      this.paint();
    });
  };

  /** Nothing is drawn until the next change. */
  cancel(): void {
    cancelAnimationFrame(this.request);
    this.request = 0;
  }

  /** Nothing is drawn any more. */
  close(): void {
    cancelAnimationFrame(this.request);
    this.request = -1;
  }
}
