/** Bytes to messages and back; columns to typed arrays. */

import { msg, str } from "@lit/localize";
import { Decoder, Encoder } from "@msgpack/msgpack";
import {
  DEFAULTS,
  MEDIA_TO_BROWSER,
  TO_BROWSER,
  TOPIC_TO_BROWSER,
  type FromBrowser,
  type MediaFromBrowser,
  type MediaToBrowser,
  type ToBrowser,
  type TopicFromBrowser,
  type TopicToBrowser,
  type Values,
} from "../generated/wire.js";
import { inPageLanguage } from "../words/hub-text.js";

/** What a page may leave out when it sends: everything that has a default. */
export type Sendable<M extends { t: keyof typeof DEFAULTS }> = M extends {
  t: infer T extends keyof typeof DEFAULTS;
}
  ? Omit<M, keyof (typeof DEFAULTS)[T]> & Partial<Pick<M, keyof (typeof DEFAULTS)[T] & keyof M>>
  : never;

/** A frame that is not in the protocol. */
export class FrameError extends Error {}

// Integers must go out as integers and floats may do so too: the hub accepts both for a float.
const encoder = new Encoder();
const decoder = new Decoder();

export function encodeMessage(message: Sendable<FromBrowser> | Sendable<MediaFromBrowser> | Sendable<TopicFromBrowser>): Uint8Array<ArrayBuffer> {
  return encoder.encode(message);
}

/**
 * Reads one frame; null for a kind of message that a newer hub knows and this page does not.
 *
 * @throws FrameError when the bytes are no message at all
 */
export function decodeMessage(bytes: ArrayBuffer): ToBrowser | null {
  return inPageLanguage(withDefaults(bytes, TO_BROWSER)) as ToBrowser | null;
}

/**
 * Reads one frame of the picture socket; null as in `decode`.
 *
 * @throws FrameError when the bytes are no message at all
 */
export function decodeMedia(bytes: ArrayBuffer): MediaToBrowser | null {
  return withDefaults(bytes, MEDIA_TO_BROWSER) as MediaToBrowser | null;
}

/**
 * Reads one frame of the socket of a raw topic; null as in `decode`.
 *
 * @throws FrameError when the bytes are no message at all
 */
export function decodeTopic(bytes: ArrayBuffer): TopicToBrowser | null {
  return withDefaults(bytes, TOPIC_TO_BROWSER) as TopicToBrowser | null;
}

function withDefaults(bytes: ArrayBuffer, known: ReadonlySet<string>): object | null {
  let raw: unknown;
  try {
    raw = decoder.decode(bytes);
  } catch (error) {
    throw new FrameError(msg(str`a frame that is not MessagePack: ${String(error)}`));
  }
  if (typeof raw !== "object" || raw === null || !("t" in raw)) {
    throw new FrameError(msg("a frame without a tag"));
  }
  const tag = raw.t;
  if (typeof tag !== "string") throw new FrameError(msg("a frame whose tag is no text"));
  if (!known.has(tag)) return null;
  return { ...DEFAULTS[tag as keyof typeof DEFAULTS], ...raw };
}

/** Samples side by side, all of one length. */
export interface ValueColumns {
  /** Index into the subscription's channel list. */
  readonly channel: Uint16Array;
  /** Microseconds since the epoch, UTC; exact up to the year 2255. */
  readonly timeUs: Float64Array;
  /** The reading; NaN where it is a text. */
  readonly value: Float64Array;
  /** Position in the batch to text. */
  readonly texts: Readonly<Record<number, string>>;
  /** Age (ms) by the hub's clock, by position; empty for fresh samples. */
  readonly ageMs: readonly number[];
}

/**
 * Reads the columns of a batch. The bytes are copied: a slice of a frame rarely starts where a
 * typed array may.
 *
 * @throws FrameError when the columns are not of one length
 */
export function columnsOf(batch: Values): ValueColumns {
  const count = batch.channel.byteLength / 2;
  if (batch.offset.byteLength !== count * 4 || batch.value.byteLength !== count * 8) {
    throw new FrameError(msg("columns of unequal length"));
  }
  const offset = new Int32Array(alignedBuffer(batch.offset));
  const timeUs = new Float64Array(count);
  for (let i = 0; i < count; i++) timeUs[i] = batch.base_us + (offset[i] ?? 0);
  return {
    channel: new Uint16Array(alignedBuffer(batch.channel)),
    timeUs,
    value: new Float64Array(alignedBuffer(batch.value)),
    texts: batch.texts,
    ageMs: batch.age_ms,
  };
}

function alignedBuffer(bytes: Uint8Array): ArrayBuffer {
  return new Uint8Array(bytes).buffer;
}
