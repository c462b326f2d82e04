/** What holds for a board that looks back: no device's link of now counts, and no command goes out. */

import { msg } from "@lit/localize";
import type { InterlockUpdate } from "../../generated/wire.js";
import type { Reachability } from "../device-reachability.js";
import type { Locks } from "../interlocks.js";

const NOTHING_CHANGES = (): (() => void) => () => undefined;

/** Whether a device is reached now says nothing of then: the age of its values does. */
export const PAST_REACH: Reachability = { subscribe: NOTHING_CHANGES, unreachableSince: () => undefined };

const LOCK: InterlockUpdate = {
  t: "interlock_news", site: "", interlock: "", name: msg("the board"), locked: true, unsafe: true, why: msg("it shows a past moment, and commands go out only from now"),
  since_us: 0, clears_ms: 0, refuses: [], targets: [], slows: [], slowed: [], overridable: false, overridden_by: "", reason: "", override_ms: 0, longest_s: 0,
  condition: "", no_override: "", unknown: [],
};

/** Locks every command, and says why; how interlocks stood then is not known. */
export const PAST_LOCKS: Locks = {
  subscribe: NOTHING_CHANGES, list: [], listAt: () => [], hasAny: () => false, interlockOf: () => undefined, lockOf: () => LOCK, slowOf: () => null, remainingMs: () => 0,
};
