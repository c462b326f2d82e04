/** The devices that a gateway does not reach now: what they last said is not true any more. */

import type { DeviceUpdate } from "../generated/wire.js";
import type { Connection } from "../wire/connection.js";
import { Store } from "./store.js";

type ReachabilityLine = Pick<Connection, "onMessage" | "onState">;

/** What elements ask about the devices that are not reached. */
export interface Reachability {
  subscribe(watcher: () => void): () => void;
  unreachableSince(site: string, device: string): DeviceUpdate | undefined;
}

export class DeviceReachability extends Store implements Reachability {
  private readonly away = new Map<string, DeviceUpdate>();

  /** Listens for as long as the connection lives. */
  constructor(line: ReachabilityLine) {
    super();
    line.onMessage("device_news", (news) => {
      const id = deviceKey(news.site, news.device);
      if (news.reached) this.away.delete(id);
      else this.away.set(id, news);
      this.notifyWatchers();
    });
    line.onMessage("site", (news) => {
      // Without its gateway all of it is stale anyway, and the gateway tells anew when it is back.
      if (!news.online) this.removeWhere((device) => device.site === news.site);
    });
    line.onState((state) => {
      if (state !== "open") this.removeWhere(() => true);
    });
  }

  /** Why a device is not reached and since when; undefined while it is. */
  unreachableSince(site: string, device: string): DeviceUpdate | undefined {
    return this.away.get(deviceKey(site, device));
  }

  private removeWhere(which: (news: DeviceUpdate) => boolean): void {
    const before = this.away.size;
    for (const [id, one] of this.away) {
      if (which(one)) this.away.delete(id);
    }
    if (this.away.size !== before) this.notifyWatchers();
  }
}

function deviceKey(site: string, device: string): string {
  return `${site}\n${device}`;
}
