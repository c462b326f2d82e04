/** Sockets of a hub that is made up for the gallery: they speak as the hub does, by its own messages. */

import { Decoder, Encoder } from "@msgpack/msgpack";
import type { Subscribe } from "../../../generated/wire.js";
import { MADE_ODOMETRY, MADE_SCAN } from "./messages.js";
import { alarmsOf, LOG_LINES, OLD_S, type Mood } from "./answers.js";
import { DETAIL, readingAt, SITE } from "./site.js";

const AGAIN_MS = 1000;
const encoder = new Encoder();
const decoder = new Decoder();

/** The hub's end of a socket is `speak`; whatever is said before anybody listens would be lost, so it begins a moment later. */
abstract class MadeSocket {
  binaryType: BinaryType = "arraybuffer";
  readyState = 1;
  readonly bufferedAmount = 0;
  onopen: (() => void) | null = null;
  onmessage: ((event: { readonly data: ArrayBuffer }) => void) | null = null;
  onclose: (() => void) | null = null;
  protected timer: ReturnType<typeof setInterval> | undefined;

  constructor(protected readonly mood: Mood) {
    queueMicrotask(() => {
      if (this.readyState !== 1) return;
      this.onopen?.();
      this.begin();
    });
  }

  protected abstract begin(): void;

  abstract send(bytes: Uint8Array): void;

  close(): void {
    this.readyState = 3;
    clearInterval(this.timer);
  }

  protected speak(message: object): void {
    if (this.readyState === 1) this.onmessage?.({ data: encoder.encode(message).slice().buffer });
  }
}

/** Values, alarms, and what devices are not reached. */
class MadeHubSocket extends MadeSocket {
  private readonly asked = new Map<number, readonly string[]>();

  protected begin(): void {
    const { mood } = this;
    this.speak({ t: "greeting", who: "gallery", role: "operator", time_us: Date.now() * 1000 });
    for (const alarm of alarmsOf(mood)) this.speak(alarm);
    if (mood === "live") this.speak({ t: "interlock_news", site: SITE, interlock: "weather", name: "Bad weather", locked: false, unsafe: false, why: "", since_us: Date.now() * 1000 - 3600e6 });
    this.speak({ t: "lease_news", site: SITE, device: "base", holder: "", yours: false, epoch: 0, remains_ms: 0 });
    this.speak({ t: "stop_news", site: SITE, device: "base", latched: false, confirmed: false, who: "", time_us: 0, id: "" });
    if (mood === "failing") for (const { id } of DETAIL.devices) this.speak({ t: "device_news", site: SITE, device: id, reached: false, why: "no answer on its port", since_us: Date.now() * 1000 - 95e6 });
    if (mood === "live") this.timer = setInterval(() => { this.tellAll(); }, AGAIN_MS);
  }

  send(bytes: Uint8Array): void {
    const message = decoder.decode(bytes) as { readonly t: string; readonly n?: number; readonly at_ms?: number };
    if (message.t === "ping") this.speak({ t: "pong", n: message.n, at_ms: message.at_ms, hub_us: Math.round(performance.now() * 1000) });
    if (message.t !== "subscribe") return;
    const { sub, channels } = message as unknown as Subscribe;
    this.asked.set(sub, channels);
    this.speak({ t: "subscribed", sub, refused: this.mood === "barred" ? channels : [] });
    this.tellValues(sub, channels);
  }

  private tellAll(): void {
    for (const [sub, channels] of this.asked) this.tellValues(sub, channels);
  }

  private tellValues(sub: number, channels: readonly string[]): void {
    if (this.mood === "empty" || this.mood === "barred") return;
    const late = this.mood === "live" ? 0 : OLD_S;
    const seconds = Date.now() / 1000 - late;
    const rows = channels.flatMap((channel, at) => {
      const value = readingAt(channel, seconds);
      return value === null ? [] : [[at, value] as const];
    });
    const texts = Object.fromEntries(rows.flatMap(([, value], at) => (typeof value === "string" ? [[at, value]] : [])));
    const column = (array: Uint16Array | Int32Array | Float64Array): Uint8Array => new Uint8Array(array.buffer);
    this.speak({
      t: "values", sub, base_us: Math.round(seconds * 1e6), channel: column(Uint16Array.from(rows, ([at]) => at)), offset: column(new Int32Array(rows.length)),
      value: column(Float64Array.from(rows, ([, value]) => (typeof value === "number" ? value : Number.NaN))), texts, age_ms: rows.map(() => late * 1000),
    });
  }
}

const TREES: Readonly<Record<string, () => object>> = {
  "/odom": () => ({ header: { frame_id: "odom" }, pose: { position: { x: 0.4, y: 0.2, z: 0 } }, twist: { linear: { x: 0.18 }, angular: { z: 0.02 } } }),
  "/diagnostics_agg": () => ({
    status: [
      ["/Robot/Arm/elbow", 0, "in order"],
      ["/Robot/Arm/wrist", 2, "over-current, switched off"],
      ["/Robot/Battery", 1, "18 % left"],
    ].map(([name, level, message]) => ({ name, level, message, hardware_id: "board 7", values: [{ key: "temperature", value: "41 °C" }] })),
  }),
  "/rosout": () => {
    const [level, name, msg] = LOG_LINES[Math.floor(Date.now() / 5000) % LOG_LINES.length] ?? [20, "base", ""];
    return { level, name, msg, stamp: { sec: Math.floor(Date.now() / 1000), nanosec: 0 } };
  },
};
const BYTES: Readonly<Record<string, Uint8Array>> = { "/odom": MADE_ODOMETRY, "/scan": MADE_SCAN };

/** One raw topic, as trees or as bytes. */
class MadeTopicSocket extends MadeSocket {
  private number = 0;

  constructor(mood: Mood, private readonly query: URLSearchParams) {
    super(mood);
  }

  send(): void {
    // What the page has shown does not matter here.
  }

  protected begin(): void {
    const { mood } = this;
    if (mood === "barred") {
      this.speak({ t: "problem", code: "forbidden", message: "Your role may not tap this topic.", about: "topic" });
      return;
    }
    const problem = mood === "failing" ? "its type is not installed at the gateway, and none of its definitions has its hash" : "";
    this.speak({ t: "topic_update", listed: true, type: "", latched: false, max_rate: 0, definition: "", problem });
    if (mood === "empty" || mood === "failing") return;
    this.tellMessage();
    if (mood === "live") this.timer = setInterval(() => { this.tellMessage(); }, AGAIN_MS);
  }

  private tellMessage(): void {
    const topic = this.query.get("topic") ?? "";
    this.number += 1;
    const late = this.mood === "live" ? 0 : OLD_S;
    const timeUs = Math.round(Date.now() * 1000 - late * 1e6);
    const head = { number: this.number, seq: this.number, time_us: timeUs, publish_us: timeUs, age_ms: late * 1000 };
    if (this.query.get("as") === "bytes") {
      const data = BYTES[topic];
      if (data !== undefined) this.speak({ t: "topic_bytes", ...head, encoding: "ros1", every: 1, data });
      return;
    }
    const tree = JSON.stringify(TREES[topic]?.() ?? {});
    this.speak({ t: "topic_message", ...head, size: tree.length, tree });
  }
}

/** A yard with a path, as a camera sees it. */
async function drawYard(): Promise<Uint8Array> {
  const picture = new OffscreenCanvas(480, 360);
  const pen = picture.getContext("2d");
  if (pen !== null) {
    pen.fillStyle = "#b9c4c8";
    pen.fillRect(0, 0, 480, 360);
    pen.fillStyle = "#8a6f55";
    pen.beginPath();
    pen.moveTo(0, 360);
    pen.lineTo(480, 360);
    pen.lineTo(292, 188);
    pen.lineTo(188, 188);
    pen.fill();
    pen.fillStyle = "#2c6e49";
    pen.fillRect(322, 142, 52, 98);
  }
  return new Uint8Array(await (await picture.convertToBlob({ type: "image/jpeg" })).arrayBuffer());
}

class MadeMediaSocket extends MadeSocket {
  private seq = 0;

  send(bytes: Uint8Array): void {
    // What the page has shown does not matter here.
    const message = decoder.decode(bytes) as { readonly t: string; readonly n?: number; readonly at_ms?: number };
    if (message.t === "ping") this.speak({ t: "pong", n: message.n, at_ms: message.at_ms, hub_us: Math.round(performance.now() * 1000) });
  }

  protected begin(): void {
    if (this.mood === "barred") this.speak({ t: "problem", code: "forbidden", message: "Your role may not see this camera.", about: "media" });
    if (this.mood === "failing") this.speak({ t: "problem", code: "picture", message: "The camera gives pictures of a form that cannot be read: 16UC1.", about: "media" });
    if (this.mood !== "live" && this.mood !== "stale") return;
    void this.tellPicture();
    if (this.mood === "live") this.timer = setInterval(() => void this.tellPicture(), AGAIN_MS / 4);
  }

  private async tellPicture(): Promise<void> {
    const data = await drawYard();
    this.seq += 1;
    const late = this.mood === "live" ? 0 : OLD_S;
    this.speak({ t: "shot", seq: this.seq, time_us: Math.round(Date.now() * 1000 - late * 1e6), hub_us: Math.round(performance.now() * 1000 - late * 1e6), width: 480, height: 360, format: "jpeg", key: true, codec: "", small: false, data });
  }
}

/** Stands in for the browser's own sockets. */
export function socketsAs(mood: Mood): (url: string) => WebSocket {
  return (url) => {
    const { pathname, searchParams } = new URL(url);
    const made = pathname === "/ws/topic" ? new MadeTopicSocket(mood, searchParams) : pathname === "/ws" ? new MadeHubSocket(mood) : new MadeMediaSocket(mood);
    return made as unknown as WebSocket;
  };
}
