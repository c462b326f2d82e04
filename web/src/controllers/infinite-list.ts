/** Ties endless rows to an element: older ones are asked for when its `.end` comes into view. */

import type { ReactiveController, ReactiveControllerHost } from "lit";
import { comeback } from "../wire/backoff.js";
import { InfiniteRows, type RowsPage, type IdentifiedRow } from "./infinite-rows.js";

type InfiniteListHost = ReactiveControllerHost & { readonly renderRoot: ParentNode };

export class InfiniteList<R extends IdentifiedRow> extends InfiniteRows<R> implements ReactiveController {
  private readonly watcher = new IntersectionObserver((entries) => {
    if (entries.some(({ isIntersecting }) => isIntersecting)) void this.loadOlder();
  });

  private stopWaiting: () => void = () => undefined;

  /** `find` and `fits` are as those of `EndlessRows`. */
  constructor(
    private readonly host: InfiniteListHost,
    find: (before: string) => Promise<RowsPage<R>>,
    fits?: (row: R) => boolean,
  ) {
    super(
      find,
      () => {
        host.requestUpdate();
      },
      fits,
    );
    host.addController(this);
  }

  hostConnected(): void {
    this.stopWaiting = comeback.subscribe(() => {
      if (this.renderFailure !== null) this.retry();
    });
  }

  hostUpdated(): void {
    // Watched anew each time: an end that has stayed in view is told of once more.
    this.watcher.disconnect();
    const end = this.host.renderRoot.querySelector(".end");
    if (end !== null && this.hasMore && this.renderFailure === null) this.watcher.observe(end);
  }

  hostDisconnected(): void {
    this.stopWaiting();
    this.watcher.disconnect();
    this.stopPolling();
  }
}
