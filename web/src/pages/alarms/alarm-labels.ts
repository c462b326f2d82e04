/** What people read of an alarm. Pure. */

import type { StatusKind } from "../../elements/feedback/status.js";
import type { AlarmNews } from "../../generated/wire.js";
import { sitePath } from "../../state/router.js";

/** Beside an alarm in the history, so much is shown on either side (µs). */
const AROUND_US = 120e6;

/** How it stands: the kind of the mark, and the word beside it. What cannot be judged is never well. */
export function standing(one: AlarmNews, shelved: boolean): readonly [StatusKind, string] {
  const over = shelved ? ", shelved" : "";
  if (one.phase === "active") return ["bad", `active${over}`];
  if (one.phase === "acknowledged") return ["warn", `active, acknowledged${over}`];
  if (one.phase === "cleared") return ["warn", `over, not acknowledged${over}`];
  return one.known ? ["ok", `well${over}`] : ["unknown", `cannot be judged${over}`];
}

/** The history page with an alarm's signals at the moment when it was raised. */
export function historyAt(one: Pick<AlarmNews, "site" | "signals" | "raised_us" | "cleared_us">): string {
  const query = new URLSearchParams(one.signals.map((signal) => ["c", signal]));
  const end = one.cleared_us > one.raised_us ? Math.min(one.cleared_us, one.raised_us + 3600e6) : one.raised_us;
  query.set("from", String(Math.round(one.raised_us - AROUND_US)));
  query.set("to", String(Math.round(end + AROUND_US)));
  return `${sitePath(one.site, "history")}?${query.toString().replaceAll("%2F", "/")}`;
}
