/** Raw topics of a past moment as bytes, in the place of sockets to the hub. */

import { msg, str } from "@lit/localize";
import type { TopicBytes } from "../generated/wire.js";
import type { PastBoard } from "../state/past/past-board.js";
import type { PastTopicState } from "../state/past/past-topics.js";
import type { RecordedMessage } from "./recorded-api.js";
import type { OpenBytes } from "./byte-topics.js";

/** What keeps a recorded topic from being shown; empty where nothing does. */
export function pastProblem({ kind, why }: PastTopicState): string {
  if (kind === "none") return msg("Not in a recording of this moment");
  if (kind === "failed") return msg("The hub did not give what was recorded");
  return kind === "unreadable" ? msg(str`It cannot be read: ${why}`) : "";
}

/** @param onReset is told which topic's messages are not so any more, before those of another moment come */
export function openPastBytes(past: PastBoard, onReset: (topic: string) => void): OpenBytes {
  return (_path, listener, { topic, rate }) => {
    let number = 0;
    const stop = past.topics.follow("bytes", topic, rate, {
      onReset: () => {
        onReset(topic);
      },
      onMessage: (message) => {
        number += 1;
        listener.onBytes?.(bytesOf(message, number, past.us));
      },
      onState: (state) => {
        const { kind, type, latched } = state;
        listener.onState(kind === "loading" ? "connecting" : "open", "");
        listener.onUpdate({ t: "topic_update", listed: kind !== "none", type, latched, max_rate: 0, definition: "", problem: pastProblem(state) });
      },
    });
    return { close: stop };
  };
}

function bytesOf({ timeUs, publishUs, encoding, every, data }: RecordedMessage, number: number, us: number): TopicBytes {
  return { t: "topic_bytes", number, seq: number, time_us: timeUs, publish_us: publishUs, age_ms: Math.max(0, us - timeUs) / 1000, encoding, every, data };
}
