/** The interlocks that lock something now, or are overridden, at every site this person sees. */

import type { InterlockUpdate } from "../generated/wire.js";
import type { Connection } from "../wire/connection.js";
import { Store } from "./store.js";

type InterlocksLine = Pick<Connection, "onMessage" | "onState">;

/** What was said of an interlock, and when by this page's monotonic clock (ms). */
export interface Interlock {
  readonly news: InterlockUpdate;
  readonly heardAt: number;
}

/** What elements ask about the interlocks. */
export type Locks = Pick<Interlocks, "subscribe" | "list" | "listAt" | "hasAny" | "interlockOf" | "lockOf" | "slowOf" | "remainingMs">;

export class Interlocks extends Store {
  private readonly known = new Map<string, Interlock>();

  /** Listens for as long as the connection lives. */
  constructor(
    line: InterlocksLine,
    private readonly now: () => number = () => performance.now(),
  ) {
    super();
    line.onMessage("interlock_news", (news) => {
      this.known.set(`${news.site}\n${news.interlock}`, { news, heardAt: this.now() });
      this.notifyWatchers();
    });
    line.onMessage("site", (news) => {
      // Without its gateway nobody knows how they stand; that it is offline is shown instead.
      if (!news.online) this.removeWhere((interlock) => interlock.news.site === news.site);
    });
    line.onState((state) => {
      if (state !== "open") this.removeWhere(() => true);
    });
  }

  /** Those that are worth a word, unsafe ones first. */
  get list(): readonly Interlock[] {
    return [...this.known.values()]
      .filter(({ news }) => news.locked || news.overridden_by !== "")
      .sort((a, b) => interlockRank(a) - interlockRank(b) || a.news.name.localeCompare(b.news.name));
  }

  /** What is worth a word on a page of a site: its own, and overrides of any site. All of them where `site` is empty. */
  listAt(site: string): readonly Interlock[] {
    // An override is shown on every page while it lasts (safety rule 10).
    return this.list.filter(({ news }) => site === "" || news.site === site || news.overridden_by !== "");
  }

  /** Whether anything was said of an interlock of a site, locked or not; of any site where `site` is empty. */
  hasAny(site = ""): boolean {
    return [...this.known.values()].some(({ news }) => site === "" || news.site === site);
  }

  /** What was last said of one, whether it locks or not; undefined before anything was. */
  interlockOf(site: string, interlock: string): Interlock | undefined {
    return this.known.get(`${site}\n${interlock}`);
  }

  /** What refuses a command of a device (or `drive`) now; null where nothing does. */
  lockOf(site: string, device: string, what: string): InterlockUpdate | null {
    const found = this.list.find(
      ({ news }) =>
        news.site === site &&
        news.overridden_by === "" &&
        (news.targets.includes(`${device}/${what}`) || news.targets.includes(`${device}/*`)),
    );
    return found?.news ?? null;
  }

  /** What slows a device's driving down now; null where nothing does. */
  slowOf(site: string, device: string): InterlockUpdate | null {
    const found = this.list.find(
      ({ news }) => news.site === site && news.overridden_by === "" && news.slowed.includes(`${device}/drive`),
    );
    return found?.news ?? null;
  }

  /** How much is left of a time (ms) that was told with the news. */
  remainingMs(interlock: Interlock, ms: number): number {
    return Math.max(0, ms - (this.now() - interlock.heardAt));
  }

  private removeWhere(which: (interlock: Interlock) => boolean): void {
    let changed = false;
    for (const [id, one] of this.known) {
      if (which(one)) changed = this.known.delete(id) || changed;
    }
    if (changed) this.notifyWatchers();
  }
}

function interlockRank({ news }: Interlock): number {
  if (news.overridden_by !== "") return 0;
  return news.unsafe ? 1 : 2;
}
