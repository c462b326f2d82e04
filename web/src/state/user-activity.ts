/** Whether a person has touched the page: that, and not the page's own doing, keeps a session. */

const KINDS = ["pointerdown", "pointermove", "keydown", "wheel"] as const;

export class UserActivity {
  private seen = false;

  constructor(private readonly target: EventTarget) {}

  start(): void {
    for (const kind of KINDS) this.target.addEventListener(kind, this.recordEvent, { passive: true, capture: true });
  }

  stop(): void {
    for (const kind of KINDS) this.target.removeEventListener(kind, this.recordEvent, { capture: true });
  }

  /** Tells whether there was a touch since this was last asked. */
  consumeTouch(): boolean {
    const seen = this.seen;
    this.seen = false;
    return seen;
  }

  private readonly recordEvent = (event: Event): void => {
    // What a script of the page dispatches is not a person.
    if (event.isTrusted) this.seen = true;
  };
}
