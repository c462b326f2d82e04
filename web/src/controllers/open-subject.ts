/** What an element has open, a form or a question: what it is about, and what opened it. */

import type { ReactiveControllerHost } from "lit";

export class OpenSubject<T> {
  private current: T | null = null;
  /** Gets the focus back: a form that closes would take it away from whoever came by keyboard. */
  private openedBy: HTMLElement | null = null;

  constructor(protected readonly host: ReactiveControllerHost) {}

  /** What it is about; null while nothing is open. */
  get subject(): T | null {
    return this.current;
  }

  get isOpen(): boolean {
    return this.current !== null;
  }

  /** For the click of the button that opens it. That button stays on the page, at least hidden. */
  opener(subject: T): (event: Event) => void {
    return (event) => {
      this.openedBy = event.currentTarget instanceof HTMLElement ? event.currentTarget : null;
      this.open(subject);
    };
  }

  open(subject: T): void {
    this.current = subject;
    this.host.requestUpdate();
  }

  readonly close = (): void => {
    if (this.current === null) return;
    this.current = null;
    this.host.requestUpdate();
    const { openedBy } = this;
    this.openedBy = null;
    void this.host.updateComplete.then(() => {
      openedBy?.focus();
    });
  };
}
