/** Who acts on the devices of all sites this person sees, by a command that is under way. */

import type { CommandUpdate } from "../generated/wire.js";
import type { Connection } from "../wire/connection.js";
import { Store } from "./store.js";

type HoldersLine = Pick<Connection, "onMessage" | "onState">;

/** One who acts: in words, and since when by this page's monotonic clock (ms). */
export interface DeviceHolder {
  readonly id: string;
  readonly site: string;
  readonly device: string;
  readonly words: string;
  readonly since: number;
}

export class DeviceHolders extends Store {
  /** By the command's id: it may be told of many times, and ends once. */
  private readonly known = new Map<string, DeviceHolder>();

  /** Listens for as long as the connection lives. */
  constructor(
    line: HoldersLine,
    private readonly now: () => number = () => performance.now(),
  ) {
    super();
    line.onMessage("command_news", (news) => {
      this.applyCommandUpdate(news);
    });
    line.onMessage("site", (news) => {
      // Without its gateway nobody knows, and it tells anew when it is back.
      if (!news.online) this.removeWhere((holder) => holder.site === news.site);
    });
    line.onState((state) => {
      if (state !== "open") this.removeWhere(() => true);
    });
  }

  /** All who act on a device, the newest first: that one a refusal names. */
  holdersOf(site: string, device: string): readonly DeviceHolder[] {
    return [...this.known.values()]
      .filter((holder) => holder.site === site && holder.device === device)
      .sort((a, b) => b.since - a.since);
  }

  private applyCommandUpdate({ id, site, device, acting, acting_s: seconds }: CommandUpdate): void {
    if (acting === "") {
      this.removeWhere((holder) => holder.site === site && holder.id === id);
      return;
    }
    const key = `${site}\n${id}`;
    // Counted from the first word of it: later ones would let the seconds jump.
    const since = this.known.get(key)?.since ?? this.now() - seconds * 1000;
    this.known.set(key, { id, site, device, words: acting, since });
    this.notifyWatchers();
  }

  private removeWhere(which: (holder: DeviceHolder) => boolean): void {
    const before = this.known.size;
    for (const [key, one] of this.known) {
      if (which(one)) this.known.delete(key);
    }
    if (this.known.size !== before) this.notifyWatchers();
  }
}
