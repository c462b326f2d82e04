import { afterEach, beforeEach, expect, test, vi } from "vitest";
import type { CameraPicture } from "../../../src/generated/wire.js";
import { H264Player, supportsH264 } from "../../../src/tiles/camera/h264-player.js";

const shot = (seq: number, key: boolean, codec = key ? "avc1.42C01E" : ""): CameraPicture => ({
  t: "shot", seq, time_us: 0, hub_us: 0, width: 1, height: 1, format: "h264", key, codec, small: false,
  data: new Uint8Array([seq]),
});

class FakeDecoder {
  static all: FakeDecoder[] = [];
  state = "unconfigured";
  configured = "";
  chunks: number[] = [];
  constructor(readonly init: { output: (frame: VideoFrame) => void; error: () => void }) {
    FakeDecoder.all.push(this);
  }
  configure(config: { codec: string }): void {
    this.state = "configured";
    this.configured = config.codec;
  }
  decode(chunk: { timestamp: number }): void {
    this.chunks.push(chunk.timestamp);
  }
  close(): void {
    this.state = "closed";
  }
  give(seq: number): void {
    this.init.output({ timestamp: seq, close: () => undefined } as VideoFrame);
  }
}

const drawn: number[] = [];
const paid: number[] = [];
let broken = 0;
let film: H264Player;

const show = (shot: CameraPicture): void => {
  film.receivePicture(shot, () => paid.push(shot.seq));
};

beforeEach(() => {
  FakeDecoder.all = [];
  drawn.length = paid.length = broken = 0;
  vi.stubGlobal("VideoDecoder", FakeDecoder);
  vi.stubGlobal("EncodedVideoChunk", class {
    timestamp: number;
    constructor(init: { timestamp: number }) {
      this.timestamp = init.timestamp;
    }
  });
  film = new H264Player({ draw: (_frame, { seq }) => drawn.push(seq), broken: () => (broken += 1) });
});
afterEach(() => {
  vi.unstubAllGlobals();
});

test("a film begins with a key picture; what comes before it is paid for and not decoded", () => {
  show(shot(1, false));
  expect([FakeDecoder.all.length, paid]).toEqual([0, [1]]);
  show(shot(2, true));
  show(shot(3, false));
  expect(FakeDecoder.all[0]?.chunks).toEqual([2, 3]);
  FakeDecoder.all[0]?.give(2);
  FakeDecoder.all[0]?.give(3);
  expect([drawn, paid]).toEqual([[2, 3], [1, 2, 3]]);
});

test("the same decoder goes on over key pictures, and a film of another kind has its own", () => {
  show(shot(1, true));
  show(shot(2, true));
  expect(FakeDecoder.all).toHaveLength(1);
  show(shot(3, true, "avc1.42C028"));
  expect(FakeDecoder.all.map((decoder) => [decoder.configured, decoder.state])).toEqual([
    ["avc1.42C01E", "closed"], ["avc1.42C028", "configured"],
  ]);
  expect(paid).toEqual([1, 2]);
});

test("a spoilt film is told, and all of it is paid for", () => {
  show(shot(1, true));
  show(shot(2, false));
  FakeDecoder.all[0]?.init.error();
  expect([broken, paid]).toEqual([1, [1, 2]]);
  FakeDecoder.all[0]?.give(2);
  expect(drawn).toEqual([]);
});

test("nothing is drawn after it is closed", () => {
  show(shot(1, true));
  film.close();
  FakeDecoder.all[0]?.give(1);
  show(shot(2, true));
  expect([drawn, FakeDecoder.all[0]?.state, FakeDecoder.all.length]).toEqual([[], "closed", 1]);
});

test("films are asked for only where the browser says that it plays them", async () => {
  const says = (supported: boolean) =>
    ({ VideoDecoder: { isConfigSupported: () => Promise.resolve({ supported }) } }) as unknown as typeof globalThis;
  expect(await supportsH264({})).toBe(false);
  expect(await supportsH264(says(false))).toBe(false);
  expect(await supportsH264(says(true))).toBe(true);
});
