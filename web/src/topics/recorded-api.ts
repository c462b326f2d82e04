/** Raw topics of past moments, as recordings hold them: which there are, and their messages. */

import { msg, str } from "@lit/localize";
import { Decoder } from "@msgpack/msgpack";
import type { MomentShape, RecordedTopicShape, StretchShape } from "../generated/api.js";
import { FrameError } from "../wire/codec.js";
import type { HubApi } from "../wire/hub-api.js";

/** A topic that is wanted, and how many large messages a second (Hz). */
export interface RecordedWish {
  readonly topic: string;
  readonly rate: number;
}

/** A message as a page gets it: as a tree, or as the robot serialized it. */
export interface RecordedMessage {
  readonly topic: string;
  /** When it came to the recorder (µs, UTC). */
  readonly timeUs: number;
  readonly publishUs: number;
  /** Bytes as the robot serialized it. */
  readonly size: number;
  /** As JSON; empty of one that is none of its type, and of bytes. */
  readonly tree: string;
  readonly encoding: string;
  readonly every: number;
  readonly data: Uint8Array;
}

/** What was recorded in a stretch of time; all before `untilUs` is there. */
export interface RecordedStretch {
  readonly topics: readonly RecordedTopicShape[];
  readonly messages: readonly RecordedMessage[];
  readonly untilUs: number;
}

interface BytesAnswer {
  readonly topics: readonly RecordedTopicShape[];
  readonly messages: readonly { topic: string; time_us: number; publish_us: number; encoding: string; every: number; data: Uint8Array }[];
  readonly until_us: number;
}

const NO_BYTES = new Uint8Array();
const decoder = new Decoder();

export class RecordedApi {
  constructor(private readonly hub: Pick<HubApi, "request" | "requestBytes">) {}

  /** The topics that recordings hold of a moment, and where the nearest other recordings are. */
  moment(site: string, atUs: number, signal?: AbortSignal): Promise<MomentShape> {
    return this.hub.request("GET", `${pathOf(site)}?at_us=${String(Math.floor(atUs))}`, undefined, { signal });
  }

  async trees(site: string, wishes: readonly RecordedWish[], fromUs: number, toUs: number, signal?: AbortSignal): Promise<RecordedStretch> {
    const answer = await this.hub.request<StretchShape>("GET", `${pathOf(site)}/messages?${queryOf(wishes, fromUs, toUs).toString()}`, undefined, { signal });
    const messages = answer.messages.map(({ topic, time_us: timeUs, publish_us: publishUs, size, tree }) => ({ topic, timeUs, publishUs, size, tree, encoding: "", every: 1, data: NO_BYTES }));
    return { topics: answer.topics, messages, untilUs: answer.until_us };
  }

  /** @param points of a cloud at the most */
  async bytes(site: string, wishes: readonly RecordedWish[], points: number, fromUs: number, toUs: number, signal?: AbortSignal): Promise<RecordedStretch> {
    const query = queryOf(wishes, fromUs, toUs);
    query.set("points", String(points));
    const answer = decodeAnswer(await this.hub.requestBytes(`${pathOf(site)}/bytes?${query.toString()}`, { signal }));
    const messages = answer.messages.map(({ topic, time_us: timeUs, publish_us: publishUs, encoding, every, data }) => ({ topic, timeUs, publishUs, size: data.byteLength, tree: "", encoding, every, data }));
    return { topics: answer.topics, messages, untilUs: answer.until_us };
  }
}

function pathOf(site: string): string {
  return `/api/sites/${encodeURIComponent(site)}/recorded-topics`;
}

function queryOf(wishes: readonly RecordedWish[], fromUs: number, toUs: number): URLSearchParams {
  const query = new URLSearchParams();
  for (const { topic, rate } of wishes) {
    query.append("topic", topic);
    query.append("rate", String(rate));
  }
  query.set("from_us", String(Math.max(0, Math.floor(fromUs))));
  query.set("to_us", String(Math.floor(toUs)));
  return query;
}

/** @throws FrameError when the bytes are no such answer */
function decodeAnswer(bytes: ArrayBuffer): BytesAnswer {
  let found: unknown;
  try {
    found = decoder.decode(bytes);
  } catch (error) {
    throw new FrameError(msg(str`an answer that is not MessagePack: ${String(error)}`));
  }
  if (typeof found !== "object" || found === null || !("messages" in found) || !Array.isArray(found.messages)) throw new FrameError(msg("an answer without messages"));
  return found as BytesAnswer;
}
