/** Ties a store from a context to an element: drawn again when the store changes. */

import { ContextConsumer, type Context } from "@lit/context";
import type { ReactiveController, ReactiveControllerHost } from "lit";

/** What `StoreController` needs of a store; see `state/store.ts`. */
export interface Watchable {
  subscribe(watcher: () => void): () => void;
}

export class ContextStoreController<S extends Watchable> implements ReactiveController {
  private found: S | undefined;
  private stop: (() => void) | undefined;

  /** @param changed called before the element is drawn again, also when the store is first found */
  constructor(
    private readonly host: ReactiveControllerHost & HTMLElement,
    context: Context<unknown, S>,
    private readonly changed?: (store: S) => void,
  ) {
    host.addController(this);
    new ContextConsumer(host, {
      context,
      callback: (store) => {
        this.found = store;
        this.subscribeStore();
      },
    });
  }

  /** Undefined until the element stands in a page that provides it. */
  get store(): S | undefined {
    return this.found;
  }

  hostConnected(): void {
    this.subscribeStore();
  }

  hostDisconnected(): void {
    this.stop?.();
    this.stop = undefined;
  }

  private subscribeStore(): void {
    const store = this.found;
    if (store === undefined || this.stop !== undefined || !this.host.isConnected) return;
    const notifyHost = (): void => {
      this.changed?.(store);
      this.host.requestUpdate();
    };
    this.stop = store.subscribe(notifyHost);
    notifyHost();
  }
}
