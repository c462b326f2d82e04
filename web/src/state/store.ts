/** Something that pages watch. */

export type StopWatching = () => void;

/** Base of the stores: says that it changed, not what. */
export class Store {
  private readonly watchers = new Set<() => void>();

  /** Calls `watcher` after each change. Returns the way to end it. */
  subscribe(watcher: () => void): StopWatching {
    this.watchers.add(watcher);
    return () => this.watchers.delete(watcher);
  }

  protected notifyWatchers(): void {
    for (const watcher of [...this.watchers]) watcher();
  }
}
