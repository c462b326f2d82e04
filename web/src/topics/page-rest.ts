/** A page that nobody looks at for a while lets the robot rest, and asks again when it is seen. */

/** What is told of visibility; a document. */
export interface PageVisibility {
  readonly hidden: boolean;
  addEventListener(type: "visibilitychange", listener: () => void): void;
  removeEventListener(type: "visibilitychange", listener: () => void): void;
}

/** Hidden for so long (ms). */
const HIDDEN_MS = 5000;

export class PageRest {
  private timer: ReturnType<typeof setTimeout> | undefined;

  /** @param listener is told when to let go, and whenever the page is seen again */
  constructor(
    private readonly listener: { readonly onRest: () => void; readonly onSeen: () => void },
    private readonly page: PageVisibility = document,
  ) {}

  watch(): void {
    this.page.addEventListener("visibilitychange", this.onVisibility);
  }

  close(): void {
    clearTimeout(this.timer);
    this.page.removeEventListener("visibilitychange", this.onVisibility);
  }

  private readonly onVisibility = (): void => {
    clearTimeout(this.timer);
    if (this.page.hidden) this.timer = setTimeout(this.listener.onRest, HIDDEN_MS);
    else this.listener.onSeen();
  };
}
