/** How far STOP got at one robot of a group, in words. Pure. */

import { msg, str } from "@lit/localize";
import type { GroupStopRow } from "../../controllers/drive/group-stop-client.js";
import type { StatusKind } from "../../elements/feedback/status.js";

/** Longer than this without an answer is worth a word. */
const LATE_MS = 1000;

export interface StopWords {
  readonly kind: StatusKind;
  readonly word: string;
  readonly text: string;
}

export function stopWords(row: Pick<GroupStopRow, "phase" | "online" | "waitingMs" | "answerMs">): StopWords {
  if (!row.online) return { kind: "offline", word: msg("not reached"), text: msg("Offline. STOP is sent the moment it is back, while this page is open. Use the stop on the robot.") };
  switch (row.phase) {
    case "confirmed":
      return { kind: "ok", word: msg("stopped"), text: msg(str`Latched, and the robot's own readings say that it stands still.${answerText(row.answerMs)}`) };
    case "latched":
      return { kind: "warn", word: msg("latched"), text: msg(str`Latched at its gateway, which sends zeros. The robot has not confirmed that it stands still.${answerText(row.answerMs)}`) };
    case "clear":
      return { kind: "warn", word: msg("released"), text: msg("Released again since.") };
    case "unknown":
      return { kind: "unknown", word: msg("not known"), text: msg("The link was lost after the press: nothing is known of it now.") };
    case "sent":
      return row.waitingMs > LATE_MS
        ? { kind: "bad", word: msg("no answer"), text: msg("No answer from its gateway yet: sent again and again.") }
        : { kind: "busy", word: msg("sent", { id: "sent.stop" }), text: msg("Sent, not answered yet.") };
  }
}

/** `2 of 3 stopped, 1 not reached`, for one line above the list. */
export function stopSummary(rows: readonly Pick<GroupStopRow, "phase" | "online" | "waitingMs" | "answerMs">[]): string {
  const counts = new Map<string, number>();
  for (const row of rows) {
    const { word } = stopWords(row);
    counts.set(word, (counts.get(word) ?? 0) + 1);
  }
  const rest = [...counts].filter(([word]) => word !== "stopped").map(([word, count]) => `${String(count)} ${word}`);
  return [msg(str`${String(counts.get("stopped") ?? 0)} of ${String(rows.length)} stopped`), ...rest].join(", ");
}

function answerText(answerMs: number | null): string {
  return answerMs === null ? "" : msg(str` Answered in ${answerMs.toFixed(0)} ms.`);
}
