/** What a gateway that did not change over said. */

import { msg } from "@lit/localize";
import type { Advice } from "../../format/error-advice.js";
import type { ChangeAnswer } from "../../generated/api.js";

/** What a gateway's answer means; null when there is nothing to say. */
export function refusalAdvice(answer: ChangeAnswer | null): Advice | null {
  if (answer === null || answer.phase === "applied") return null;
  const what = answer.phase === "refused" ? msg("The gateway refused it.") : msg("It is not known whether it was done.");
  return { what, how: answer.message };
}
