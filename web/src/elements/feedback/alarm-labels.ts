/** What people read of an alarm. Pure. */

import { msg, str } from "@lit/localize";
import type { StatusKind } from "./status.js";
import type { AlarmUpdate } from "../../generated/wire.js";
import { sitePath } from "../../state/router.js";

/** Beside an alarm in the history, so much is shown on either side (µs). */
const AROUND_US = 120e6;

/** How it stands: the kind of the mark, and the word beside it. What cannot be judged is never well. */
export function alarmStatus(alarm: AlarmUpdate, shelved: boolean): readonly [StatusKind, string] {
  const over = shelved ? msg(", shelved") : "";
  if (alarm.phase === "active") return ["bad", `active${over}`];
  if (alarm.phase === "acknowledged") return ["warn", msg(str`active, acknowledged${over}`)];
  if (alarm.phase === "cleared") return ["warn", msg(str`over, not acknowledged${over}`)];
  return alarm.known ? ["ok", `well${over}`] : ["unknown", msg(str`cannot be judged${over}`)];
}

/** The history page with an alarm's signals at the moment when it was raised. */
export function historyAt(alarm: Pick<AlarmUpdate, "site" | "signals" | "raised_us" | "cleared_us">): string {
  const query = new URLSearchParams(alarm.signals.map((signal) => ["c", signal]));
  const end = alarm.cleared_us > alarm.raised_us ? Math.min(alarm.cleared_us, alarm.raised_us + 3600e6) : alarm.raised_us;
  query.set("from", String(Math.round(alarm.raised_us - AROUND_US)));
  query.set("to", String(Math.round(end + AROUND_US)));
  return `${sitePath(alarm.site, "history")}?${query.toString().replaceAll("%2F", "/")}`;
}
