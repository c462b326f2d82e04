/** How many rows of a long list are drawn: more as the end of those that are there comes near the view. */

import type { ReactiveController, ReactiveControllerHost } from "lit";
import type { SiteSummary } from "../../generated/api.js";
import type { FleetGroup } from "./fleet-list.js";

/** Rows at first, and more each time. */
const STEP = 60;
/** So far beside the view is near. */
const NEAR = "800px";

export class ShownRowsController implements ReactiveController {
  private shown = STEP;
  private readonly watcher = new IntersectionObserver(
    (entries) => {
      if (!entries.some(({ isIntersecting }) => isIntersecting)) return;
      this.shown += STEP;
      this.host.requestUpdate();
    },
    { rootMargin: NEAR },
  );

  /** @param end gives the element behind the rows that are drawn; null once all are */
  constructor(
    private readonly host: ReactiveControllerHost,
    private readonly end: () => Element | null,
  ) {
    host.addController(this);
  }

  /** The first rows of groups, as many as are drawn now: those of each group that has any, and whether an end is to stand behind them. */
  firstOf(groups: readonly FleetGroup[]): { readonly drawn: readonly { readonly group: FleetGroup; readonly rows: readonly SiteSummary[] }[]; readonly ends: boolean } {
    let left = this.shown;
    const drawn = groups.flatMap((group) => {
      const rows = group.rows.slice(0, Math.max(0, left));
      left -= rows.length;
      return rows.length === 0 ? [] : [{ group, rows }];
    });
    return { drawn, ends: left <= 0 };
  }

  /** Another list: from its beginning. */
  restart(): void {
    this.shown = STEP;
    this.host.requestUpdate();
  }

  hostUpdated(): void {
    // Watched anew each time: an end that has stayed in view is told of once more.
    this.watcher.disconnect();
    const end = this.end();
    if (end !== null) this.watcher.observe(end);
  }

  hostDisconnected(): void {
    this.watcher.disconnect();
  }
}
