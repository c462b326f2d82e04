/** What is the matter at each site, by its alarms. Pure. */

import type { Alarms } from "../state/alarms.js";

/** What is the matter at a site: counts of alarms that nobody has settled. */
export interface SiteTrouble {
  readonly bad: number;
  readonly warn: number;
}

export const NO_TROUBLE: SiteTrouble = { bad: 0, warn: 0 };

/** Alarms that nobody has settled, by site. */
export function troublesOf(alarms: Pick<Alarms, "list" | "isShelved"> | undefined): ReadonlyMap<string, SiteTrouble> {
  const counts = new Map<string, { bad: number; warn: number }>();
  for (const alarm of alarms?.list ?? []) {
    if (alarm.phase === "normal" || alarms?.isShelved(alarm) === true) continue;
    const count = counts.get(alarm.site) ?? { bad: 0, warn: 0 };
    if (alarm.severity === "critical") count.bad += 1;
    else if (alarm.severity === "warning") count.warn += 1;
    counts.set(alarm.site, count);
  }
  return counts;
}

/** Those of one site. */
export function troubleAt(alarms: Pick<Alarms, "list" | "isShelved"> | undefined, site: string): SiteTrouble {
  return troublesOf(alarms).get(site) ?? NO_TROUBLE;
}
