/** What people read of an alarm. Pure. */

import { msg, str } from "@lit/localize";
import type { StatusKind } from "./status.js";
import type { AlarmUpdate } from "../../generated/wire.js";
import { sitePath } from "../../state/router.js";

/** Beside an alarm in the history, so much is shown on either side (µs). */
const AROUND_US = 120e6;

/** How it stands: the kind of the mark, and the word beside it. What cannot be judged is never well. */
export function alarmStatus(alarm: AlarmUpdate, shelved: boolean): readonly [StatusKind, string] {
  const [kind, word] = phaseStatus(alarm);
  return [kind, shelved ? msg(str`${word}, shelved`) : word];
}

function phaseStatus({ phase, known }: AlarmUpdate): readonly [StatusKind, string] {
  switch (phase) {
    case "active":
      return ["bad", msg("active")];
    case "acknowledged":
      return ["warn", msg("active, acknowledged")];
    case "cleared":
      return ["warn", msg("over, not acknowledged")];
    default:
      return known ? ["ok", msg("well", { id: "well.alarm" })] : ["unknown", msg("cannot be judged")];
  }
}

/** The history page with an alarm's signals at the moment when it was raised. */
export function historyAt(alarm: Pick<AlarmUpdate, "site" | "signals" | "raised_us" | "cleared_us">): string {
  const query = new URLSearchParams(alarm.signals.map((signal) => ["c", signal]));
  const end = alarm.cleared_us > alarm.raised_us ? Math.min(alarm.cleared_us, alarm.raised_us + 3600e6) : alarm.raised_us;
  query.set("from", String(Math.round(alarm.raised_us - AROUND_US)));
  query.set("to", String(Math.round(end + AROUND_US)));
  return `${sitePath(alarm.site, "history")}?${query.toString().replaceAll("%2F", "/")}`;
}
