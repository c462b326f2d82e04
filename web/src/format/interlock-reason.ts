/** Why something cannot be asked now, and who can help. */

import { msg, str } from "@lit/localize";
import type { InterlockUpdate } from "../generated/wire.js";

/** One or two sentences for beside the button that is locked. */
export function lockText(news: InterlockUpdate): string {
  const why = news.unsafe ? (news.why === "" ? msg("unsafe now") : news.why) : msg("safe now, but not for long enough yet");
  return msg(str`Locked by ${news.name}: ${why}. ${helpText(news)}`).trim();
}

function helpText(news: InterlockUpdate): string {
  if (news.longest_s > 0) return msg("You can override it in the bar at the top.");
  if (news.no_override !== "") return msg(str`It cannot be overridden now: ${news.no_override}.`);
  return news.overridable ? msg("An admin can override it.") : "";
}
