/** Something that pages watch. */

export type Unsubscribe = () => void;

/** Base of the stores: says that it changed, not what. */
export class Store {
  private readonly watchers = new Set<() => void>();

  /** Calls `watcher` after each change. Returns the way to end it. */
  subscribe(watcher: () => void): Unsubscribe {
    this.watchers.add(watcher);
    return () => this.watchers.delete(watcher);
  }

  protected notifyWatchers(): void {
    for (const watcher of [...this.watchers]) watcher();
  }
}
