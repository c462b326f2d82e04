import { Encoder } from "@msgpack/msgpack";
import { describe, expect, test } from "vitest";
import { columnsOf, decodeMessage, decodeMedia, encodeMessage, FrameError } from "../../src/wire/codec.js";
import type { Values } from "../../src/generated/wire.js";

const pack = (value: unknown): ArrayBuffer => new Encoder().encode(value).slice().buffer;

describe("messages", () => {
  test("fields that the hub left out take their defaults", () => {
    expect(decodeMessage(pack({ t: "site", site: "agv", online: true, since_us: 5 }))).toEqual({
      t: "site", site: "agv", online: true, since_us: 5, catalogue: "", loop_ms: 0, skew_ms: 0, why: "", rival_us: 0, away: false,
    });
  });

  test("what the hub did say is kept, also when it equals nothing", () => {
    expect(decodeMessage(pack({ t: "event", site: "agv", kind: "lost", good: false }))).toMatchObject({ good: false });
  });

  test("a kind of message that only a newer hub knows is passed over", () => {
    expect(decodeMessage(pack({ t: "horoscope" }))).toBeNull();
    expect(decodeMedia(pack({ t: "values" }))).toBeNull();
  });

  test.each([
    ["no map", pack(7)],
    ["null", pack(null)],
    ["no tag", pack({ site: "agv" })],
    ["a number for a tag", pack({ t: 3 })],
    ["no MessagePack", new Uint8Array([0xc1, 0xff]).buffer],
    ["half a message", pack({ t: "greeting", who: "ana" }).slice(0, 9)],
    ["nothing", new ArrayBuffer(0)],
  ])("%s is refused as a frame", (_name, bytes) => {
    expect(() => decodeMessage(bytes)).toThrow(FrameError);
  });

  test("random bytes are a message, unknown or refused, and never anything else", () => {
    let seed = 7;
    for (let round = 0; round < 3000; round++) {
      const bytes = new Uint8Array(1 + (round % 40)).map(() => (seed = (seed * 48271) % 2147483647) & 255);
      try {
        decodeMessage(bytes.buffer);
      } catch (error) {
        expect(error).toBeInstanceOf(FrameError);
      }
    }
  });

  test("microseconds since the epoch survive the way there and back", () => {
    const now = 1_795_236_304_429_807;
    expect(decodeMessage(pack({ t: "tick", site: "agv", tick: now }))).toMatchObject({ tick: now });
    expect(decodeMessage(encodeMessage({ t: "ping", n: 1, at_ms: 2.5 }).slice().buffer)).toBeNull();
  });
});

describe("columns", () => {
  const batch = (change: Partial<Values> = {}): Values => ({
    t: "values",
    sub: 1,
    base_us: 1_795_236_304_000_000,
    channel: new Uint8Array([0, 0, 3, 0]),
    offset: new Uint8Array(new Int32Array([0, -1500]).buffer),
    value: new Uint8Array(new Float64Array([0.25, Number.NaN]).buffer),
    texts: { 1: "parked" },
    age_ms: [],
    ...change,
  });

  test("times count from the base, also backwards", () => {
    expect([...columnsOf(batch()).timeUs]).toEqual([1_795_236_304_000_000, 1_795_236_303_998_500]);
  });

  test("columns are read wherever they stand in the frame", () => {
    const frame = new Uint8Array(40);
    frame.set(new Uint8Array(new Float64Array([0.25, -7]).buffer), 3);
    expect([...columnsOf(batch({ value: frame.subarray(3, 19) })).value]).toEqual([0.25, -7]);
  });

  test("a text stands at its place, with no number there", () => {
    const read = columnsOf(batch());
    expect([read.texts[1], read.value[1], read.channel[1]]).toEqual(["parked", Number.NaN, 3]);
  });

  test("columns of unequal length are refused", () => {
    expect(() => columnsOf(batch({ offset: new Uint8Array(4) }))).toThrow(FrameError);
    expect(() => columnsOf(batch({ value: new Uint8Array(17) }))).toThrow(FrameError);
    expect(() => columnsOf(batch({ channel: new Uint8Array(3) }))).toThrow(FrameError);
  });
});
