/**
 * What was last said of each device's lease and STOP. The hub says it when the connection opens
 * and at each change; a page that is opened later must not begin without it.
 */

import type { HeldStopUpdate, LeaseUpdate, StopUpdate, TwinUpdate } from "../generated/wire.js";
import type { Connection } from "../wire/connection.js";

type RobotStateLine = Pick<Connection, "onMessage" | "onState">;

export class RobotState {
  private readonly leases = new Map<string, LeaseUpdate>();
  private readonly stops = new Map<string, StopUpdate>();
  private readonly heldStops = new Map<string, HeldStopUpdate>();
  private readonly twins = new Map<string, TwinUpdate>();

  /** Listens for as long as the connection lives. */
  constructor(line: RobotStateLine) {
    line.onMessage("lease_news", (news) => this.leases.set(deviceKey(news.site, news.device), news));
    line.onMessage("stop_news", (news) => this.stops.set(deviceKey(news.site, news.device), news));
    line.onMessage("held_stop_news", (news) => this.heldStops.set(deviceKey(news.site, news.device), news));
    line.onMessage("twin_news", (news) => this.twins.set(deviceKey(news.site, news.device), news));
    line.onMessage("site", (news) => {
      if (!news.online) this.removeSite(news.site);
    });
    line.onState((state) => {
      if (state === "open") return;
      this.leases.clear();
      this.stops.clear();
      this.heldStops.clear();
      this.twins.clear();
    });
  }

  leaseOf(site: string, device: string): LeaseUpdate | undefined {
    return this.leases.get(deviceKey(site, device));
  }

  /** Whether a device is held from this very page. */
  holdsAny(): boolean {
    return [...this.leases.values()].some(({ yours }) => yours);
  }

  stopOf(site: string, device: string): StopUpdate | undefined {
    return this.stops.get(deviceKey(site, device));
  }

  /** At gateways that wait while another one with their key is linked. */
  heldStopOf(site: string, device: string): HeldStopUpdate | undefined {
    return this.heldStops.get(deviceKey(site, device));
  }

  /** The switch and the rehearsal of a device's twin. */
  twinOf(site: string, device: string): TwinUpdate | undefined {
    return this.twins.get(deviceKey(site, device));
  }

  private removeSite(site: string): void {
    for (const known of [this.leases, this.stops, this.heldStops, this.twins]) {
      for (const [id, news] of known) if (news.site === site) known.delete(id);
    }
  }
}

function deviceKey(site: string, device: string): string {
  return `${site}\n${device}`;
}
