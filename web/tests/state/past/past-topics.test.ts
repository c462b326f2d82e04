import { describe, expect, test } from "vitest";
import type { MomentShape, RecordedTopicShape } from "../../../src/generated/api.js";
import { PastBoard } from "../../../src/state/past/past-board.js";
import type { PastSource } from "../../../src/state/past/past-chunks.js";
import { STRETCH_US, type PastTopicSource } from "../../../src/state/past/past-topics.js";
import { openPastBytes } from "../../../src/topics/past-bytes.js";
import type { RecordedMessage, RecordedStretch, RecordedWish } from "../../../src/topics/recorded-api.js";

const S = 1e6;
const THEN = 28_000_000 * 60 * S;
const NOW = THEN + 3600 * S;

/** A recording of a minute: `/tick` says each second how many have passed, `/map` once at its begin; `/dense` is too much at once. */
class Recording implements PastTopicSource {
  readonly asked: { topics: string; fromS: number; toS: number }[] = [];
  broken = false;
  private readonly beginUs = THEN;
  private readonly endUs = THEN + 60 * S;

  moment(_site: string, us: number): Promise<MomentShape> {
    const inside = this.beginUs <= us && us <= this.endUs;
    return Promise.resolve({
      topics: inside ? [this.shape("/map"), this.shape("/tick")] : [],
      earlier_us: this.endUs < us ? this.endUs : null,
      later_us: this.beginUs > us ? this.beginUs : null,
      problems: [],
    });
  }

  trees(_site: string, wishes: readonly RecordedWish[], fromUs: number, toUs: number): Promise<RecordedStretch> {
    this.asked.push({ topics: wishes.map(({ topic }) => topic).join(" "), fromS: (fromUs - THEN) / S, toS: (toUs - THEN) / S });
    if (this.broken) return Promise.reject(new Error("down"));
    if (toUs <= this.beginUs || fromUs > this.endUs) return Promise.resolve({ topics: [], messages: [], untilUs: toUs });
    const untilUs = wishes.some(({ topic }) => topic === "/dense") ? Math.min(toUs, fromUs + S) : toUs;
    const messages = wishes.flatMap(({ topic }) => {
      const times = topic === "/map" ? [0] : Array.from({ length: 61 }, (_, second) => second);
      const known = times.map((second) => messageOf(topic, THEN + second * S, second));
      const before = known.filter(({ timeUs }) => timeUs < fromUs).slice(-1);
      return [...before, ...known.filter(({ timeUs }) => timeUs >= fromUs && timeUs < untilUs)];
    });
    return Promise.resolve({ topics: wishes.map(({ topic }) => this.shape(topic)), messages, untilUs });
  }

  bytes(site: string, wishes: readonly RecordedWish[], _points: number, fromUs: number, toUs: number): Promise<RecordedStretch> {
    return this.trees(site, wishes, fromUs, toUs);
  }

  private shape(topic: string): RecordedTopicShape {
    return { topic, type: "std_msgs/msg/String", latched: topic === "/map", problem: topic === "/odd" ? "its messages are encoded as json" : "", begin_us: this.beginUs, end_us: this.endUs };
  }
}

function messageOf(topic: string, timeUs: number, second: number): RecordedMessage {
  return { topic, timeUs, publishUs: 0, size: 10, tree: String(second), encoding: "cdr", every: 1, data: Uint8Array.of(second) };
}

const NO_SAMPLES: PastSource = {
  history: () => Promise.resolve({ series: [] }),
  lastValues: () => Promise.resolve({ values: [] }),
};

const settle = async (): Promise<void> => {
  for (let i = 0; i < 60; i += 1) await Promise.resolve();
};

function lookBack(us: number, source = new Recording()): { board: PastBoard; source: Recording; told: string[]; follow: (topic: string) => () => void; play: (seconds: number) => Promise<void> } {
  let ms = 1000;
  const board = new PastBoard("agv", NO_SAMPLES, us, { nowMs: () => ms, wallUs: () => NOW }, source);
  const told: string[] = [];
  const follow = (topic: string): (() => void) =>
    board.topics.follow("trees", topic, 5, {
      onReset: () => told.push(`${topic} anew`),
      onMessage: ({ tree }) => told.push(`${topic} ${tree}`),
      onState: ({ kind, why }) => told.push(`${topic} is ${kind}${why === "" ? "" : `: ${why}`}`),
    });
  const play = async (seconds: number): Promise<void> => {
    for (let passed = 0; passed < seconds * 1000; passed += 50) {
      ms += 50;
      board.tick();
      await settle();
    }
  };
  return { board, source, told, follow, play };
}

describe("raw topics in the past", () => {
  test("tell what came shortly before the moment, and of what is latched all that holds", async () => {
    const { told, follow } = lookBack(THEN + 30.5 * S);
    follow("/tick");
    follow("/map");
    await settle();
    expect(told.filter((line) => line.startsWith("/tick"))).toEqual(["/tick is loading", "/tick anew", "/tick is there", ...[23, 24, 25, 26, 27, 28, 29, 30].map((second) => `/tick ${String(second)}`)]);
    expect(told.filter((line) => line.startsWith("/map"))).toEqual(["/map is loading", "/map anew", "/map is there", "/map 0"]);
  });

  test("come one by one as the moment moves, each once", async () => {
    const { board, told, follow, play } = lookBack(THEN + 30.5 * S);
    follow("/tick");
    await settle();
    told.length = 0;
    board.play();
    await play(9);
    expect(told).toEqual([31, 32, 33, 34, 35, 36, 37, 38, 39].map((second) => `/tick ${String(second)}`));
  });

  test("are told anew where the moment is put elsewhere, also back", async () => {
    const { board, told, follow } = lookBack(THEN + 30 * S);
    follow("/tick");
    await settle();
    told.length = 0;
    board.seek(THEN + 1.5 * S);
    await settle();
    expect(told).toEqual(["/tick is loading", "/tick anew", "/tick is there", "/tick 0", "/tick 1"]);
    told.length = 0;
    board.seek(THEN + 2 * S);
    expect(told).toEqual(["/tick anew", "/tick 0", "/tick 1", "/tick 2"]);
  });

  test("say beyond the recording that nothing is there, and where the nearest recording is", async () => {
    const { board, told, follow } = lookBack(THEN + 59 * S);
    follow("/tick");
    await settle();
    told.length = 0;
    board.seek(THEN + 70 * S);
    await settle();
    expect(told.at(-1)).toBe("/tick is none");
    expect(board.topics.moment).toBeNull();
    await settle();
    expect(board.topics.moment).toMatchObject({ topics: [], earlier_us: THEN + 60 * S, later_us: null });
    board.seek(THEN + 60 * S);
    await settle();
    expect(told.at(-1)).toBe("/tick 60");
  });

  test("are asked for in stretches, all topics at once and each stretch once", async () => {
    const { board, source, follow } = lookBack(THEN + 30 * S);
    follow("/tick");
    follow("/map");
    await settle();
    for (let second = 30; second < 32; second += 0.1) board.seek(THEN + second * S);
    await settle();
    expect(new Set(source.asked.map(({ topics }) => topics))).toEqual(new Set(["/tick /map"]));
    expect(source.asked.map(({ fromS }) => fromS).sort((a, b) => a - b)).toEqual([20, 24, 28]);
    expect(source.asked.every(({ fromS, toS }) => toS - fromS === STRETCH_US / S)).toBe(true);
  });

  test("that are too much at once are asked for piece by piece", async () => {
    const { told, follow } = lookBack(THEN + 30.5 * S);
    follow("/dense");
    await settle();
    expect(told.slice(-8)).toEqual([23, 24, 25, 26, 27, 28, 29, 30].map((second) => `/dense ${String(second)}`));
  });

  test("say why they cannot be read, and that the hub did not answer until it is asked again", async () => {
    const { board, source, told, follow } = lookBack(THEN + 30 * S);
    follow("/odd");
    await settle();
    expect(told).toContain("/odd is unreadable: its messages are encoded as json");
    source.broken = true;
    follow("/tick");
    board.seek(THEN + 10 * S);
    await settle();
    expect(told).toContain("/tick is failed");
    source.broken = false;
    board.seek(THEN + 10 * S);
    await settle();
    expect(told.at(-1)).toBe("/tick 10");
  });

  test("hold the moment back while what it needs has not come", async () => {
    const { board, source, follow, play } = lookBack(THEN + 30 * S);
    follow("/tick");
    await settle();
    let release: () => void = () => undefined;
    const trees = source.trees.bind(source);
    const gate = new Promise<void>((resolve) => (release = resolve));
    source.trees = async (...asked) => {
      await gate;
      return trees(...asked);
    };
    board.play();
    await play(6);
    // The end of the stretch that is known.
    expect((board.us - THEN) / S).toBeLessThan(32.2);
    release();
    await settle();
    await play(2);
    expect((board.us - THEN) / S).toBeGreaterThan(33);
  });

  test("stand in for sockets of bytes: the age of a message is that of the moment", async () => {
    const { board } = lookBack(THEN + 30.5 * S);
    const heard: string[] = [];
    const open = openPastBytes(board, (topic) => heard.push(`anew ${topic}`));
    const socket = open("", {
      onUpdate: ({ listed, problem }) => heard.push(`${String(listed)} ${problem}`),
      onMessage: () => undefined,
      onBytes: ({ data, age_ms }) => heard.push(`${String(data[0])} ${String(age_ms)}`),
      onTrouble: () => undefined,
      onState: (link) => heard.push(link),
    }, { topic: "/tick", rate: 10, points: 0 });
    await settle();
    expect(heard.slice(-4)).toEqual(["open", "true ", "29 1500", "30 500"]);
    board.seek(THEN + 90 * S);
    await settle();
    expect(heard.at(-1)).toBe("false Not in a recording of this moment");
    socket.close();
  });
});
