/** How every alarm stands that this person may see, as the hub last said. */

import type { AlarmUpdate } from "../generated/wire.js";
import type { Connection } from "../wire/connection.js";
import { Store } from "./store.js";

type AlarmsLine = Pick<Connection, "onMessage" | "onState">;

/** What the bar on every page says. */
export interface AlarmSummary {
  /** Active or over, and nobody has acknowledged them; the worst first. */
  readonly unseen: readonly AlarmUpdate[];
  /** Those of which a message did not reach somebody. */
  readonly undelivered: readonly AlarmUpdate[];
}

const RANKS: Readonly<Record<string, number>> = { critical: 0, warning: 1, info: 2 };
const PHASES: Readonly<Record<string, number>> = { active: 0, cleared: 1, acknowledged: 2, normal: 4 };

export class Alarms extends Store {
  private readonly known = new Map<string, AlarmUpdate>();
  /** When each was last raised, also over a lost connection: by it what is new is told from what was there. */
  private readonly raisedAt = new Map<string, number>();
  /** Those that were raised since this page was opened; a sound is made for each, once. */
  private fresh = 0;

  /** Listens for as long as the connection lives. */
  constructor(
    line: AlarmsLine,
    private readonly nowUs: () => number = () => Date.now() * 1000,
  ) {
    super();
    line.onMessage("alarm", (news) => {
      const id = `${news.site}\n${news.alarm}`;
      const before = this.raisedAt.get(id);
      this.raisedAt.set(id, news.raised_us);
      if (news.gone) this.known.delete(id);
      else this.known.set(id, news);
      if (before !== undefined && news.phase === "active" && news.raised_us !== before && !this.isShelved(news)) {
        this.fresh += 1;
      }
      this.notifyWatchers();
    });
    line.onMessage("site", (news) => {
      // Of several hubs the one that judges these is away; when it is back, it tells of each anew.
      if (news.away) this.removeSite(news.site);
    });
    line.onState((state) => {
      // Nobody knows how they stand now; that there is no connection is shown instead.
      if (state !== "open" && this.known.size > 0) {
        this.known.clear();
        this.notifyWatchers();
      }
    });
  }

  /** All of them: the worst and newest first, those that are well last. */
  get list(): readonly AlarmUpdate[] {
    return [...this.known.values()].sort(
      (a, b) =>
        this.sortKey(a) - this.sortKey(b) ||
        (RANKS[a.severity] ?? 9) - (RANKS[b.severity] ?? 9) ||
        b.raised_us - a.raised_us ||
        a.name.localeCompare(b.name),
    );
  }

  get summary(): AlarmSummary {
    const shown = this.list.filter((alarm) => !this.isShelved(alarm));
    return {
      unseen: shown.filter(({ phase }) => phase === "active" || phase === "cleared"),
      undelivered: shown.filter(({ undelivered, phase }) => undelivered !== "" && phase !== "normal"),
    };
  }

  /** How many have been raised since the page was opened. */
  get raised(): number {
    return this.fresh;
  }

  find(site: string, alarm: string): AlarmUpdate | undefined {
    return this.known.get(`${site}\n${alarm}`);
  }

  isShelved(alarm: AlarmUpdate): boolean {
    return alarm.shelved_until_us > this.nowUs();
  }

  private removeSite(site: string): void {
    const ids = [...this.known].flatMap(([id, news]) => (news.site === site ? [id] : []));
    for (const id of ids) this.known.delete(id);
    if (ids.length > 0) this.notifyWatchers();
  }

  /** What cannot be judged stands before what is well. */
  private sortKey(alarm: AlarmUpdate): number {
    if (this.isShelved(alarm)) return 5;
    if (alarm.phase === "normal" && !alarm.known) return 3;
    return PHASES[alarm.phase] ?? 4;
  }
}
