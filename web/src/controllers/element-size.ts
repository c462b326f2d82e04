/** How large an element is, for what it places itself; it is drawn anew when that changes. */

import type { ReactiveController, ReactiveControllerHost } from "lit";

export class ElementSizeController implements ReactiveController {
  /** CSS pixels; zeros until it was measured. */
  size = { width: 0, height: 0 };
  private readonly observer = new ResizeObserver(() => {
    this.size = { width: this.host.clientWidth, height: this.host.clientHeight };
    this.host.requestUpdate();
  });

  constructor(private readonly host: ReactiveControllerHost & HTMLElement) {
    host.addController(this);
  }

  hostConnected(): void {
    this.observer.observe(this.host);
  }

  hostDisconnected(): void {
    this.observer.disconnect();
  }
}
