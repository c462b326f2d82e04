/** Draws an element again when a store changes that is handed to it and may be another one later. */

import type { ReactiveController, ReactiveControllerHost } from "lit";
import type { Watchable } from "./context-store.js";

export class StoreController implements ReactiveController {
  private watched: Watchable | null = null;
  private stop: (() => void) | null = null;

  constructor(private readonly host: ReactiveControllerHost) {
    host.addController(this);
  }

  /** Call it from `willUpdate`; the same store again changes nothing. */
  setStore(store: Watchable | null): void {
    if (store === this.watched) return;
    this.stop?.();
    this.watched = store;
    this.stop =
      store?.subscribe(() => {
        this.host.requestUpdate();
      }) ?? null;
  }

  hostConnected(): void {
    this.host.requestUpdate();
  }

  hostDisconnected(): void {
    this.stop?.();
    this.stop = null;
    this.watched = null;
  }
}
