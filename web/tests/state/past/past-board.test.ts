import { describe, expect, test } from "vitest";
import { momentText, readBoardQuery, writeBoardQuery } from "../../../src/boards/board-query.js";
import { barSpan } from "../../../src/elements/board/time-bar.js";
import type { HistoryAnswer, SignalShape, ValueList } from "../../../src/generated/api.js";
import { PastBoard } from "../../../src/state/past/past-board.js";
import type { PastSource } from "../../../src/state/past/past-chunks.js";
import type { HistoryQuery } from "../../../src/wire/hub-api.js";
import type { Batch } from "../../../src/wire/subscriptions.js";

const S = 1e6;
const MINUTE = 60 * S;
/** A round minute, an hour before it is "now". */
const THEN = 28_000_000 * MINUTE;
const NOW = THEN + 60 * MINUTE;

/** A robot that says each second how many seconds of its recording have passed; `base/word` says it in words. */
class Recorder implements PastSource {
  readonly asked: { channels: readonly string[]; fromUs: number; toUs: number }[] = [];
  broken = false;
  constructor(readonly fromUs = THEN - 10 * MINUTE, readonly toUs = NOW) {}

  history(_site: string, { channels, fromUs, toUs }: HistoryQuery): Promise<HistoryAnswer> {
    this.asked.push({ channels, fromUs, toUs });
    if (this.broken) return Promise.reject(new Error("down"));
    const times: number[] = [];
    for (let us = Math.max(this.fromUs, fromUs); us < Math.min(this.toUs, toUs); us += S) times.push(us);
    return Promise.resolve({
      series: channels.map((address) => ({
        address, kind: "exact" as const, t_us: times, v: times.map((us) => (address === "base/word" ? null : (us - THEN) / S)), gaps: [],
        ...(address === "base/word" ? { text: times.map((us) => `second ${String((us - THEN) / S)}`) } : {}),
      })),
    });
  }

  lastValues(_site: string, channels: readonly string[], beforeUs: number): Promise<ValueList> {
    const t = Math.min(beforeUs, this.toUs) - S;
    return Promise.resolve({ values: t < this.fromUs ? [] : channels.map((address) => ({ address, t_us: t, v: (t - THEN) / S })) });
  }
}

class Hands {
  ms = 1000;
  constructor(private readonly startUs = NOW) {}
  readonly nowMs = (): number => this.ms;
  readonly wallUs = (): number => this.startUs + (this.ms - 1000) * 1000;
}

const settle = async (): Promise<void> => {
  for (let i = 0; i < 20; i += 1) await Promise.resolve();
};

function boardAt(us: number, source = new Recorder()): { board: PastBoard; hands: Hands; source: Recorder; play: (ms: number) => Promise<void> } {
  const hands = new Hands();
  const board = new PastBoard("agv", source, us, hands);
  const play = async (ms: number): Promise<void> => {
    for (let passed = 0; passed < ms; passed += 50) {
      hands.ms += 50;
      board.tick();
      await settle();
    }
  };
  return { board, hands, source, play };
}

const SIGNAL: SignalShape = {
  id: "speed", address: "base/speed", name: "Speed", type: "number", role: "none", unit: "m/s", decimals: 1, minimum: null, maximum: null, shown: null, states: [], meanings: [],
  frame: "", max_age: 5, primary: true, public: false, ros: "", channels: ["base/speed"],
};

describe("a board in the past", () => {
  test("reads each value as it was at the moment, with its age of then", async () => {
    const { board } = boardAt(THEN + 30.4 * S);
    let told = 0;
    board.values.watchChannel("agv", "base/speed", () => (told += 1));
    board.values.watchChannel("agv", "base/word", () => undefined);
    expect(board.values.latestReading("agv", "base/speed")).toBeUndefined();
    expect(board.state).toBe("loading");
    await settle();
    const reading = board.values.latestReading("agv", "base/speed");
    expect(reading).toMatchObject({ value: 30, timeUs: THEN + 30 * S });
    expect(reading && board.values.ageS(reading)).toBeCloseTo(0.4);
    expect(board.values.latestReading("agv", "base/word")?.text).toBe("second 30");
    expect(board.values.latestReading("other", "base/speed")).toBeUndefined();
    expect([board.state, told > 0]).toEqual(["ready", true]);
  });

  test("asks for all signals of the board at once, and once", async () => {
    const { board, source } = boardAt(THEN);
    for (let i = 0; i < 20; i += 1) board.values.watchChannel("agv", `base/s${String(i)}`, () => undefined);
    await settle();
    board.step(3 * S);
    board.step(-2 * S);
    await settle();
    expect(source.asked.map(({ channels }) => channels.length)).toEqual([20]);
  });

  test("plays at its speed, asks ahead, and never shows what is not there yet", async () => {
    const { board, play, source } = boardAt(THEN + 50 * S);
    board.values.watchChannel("agv", "base/speed", () => undefined);
    await settle();
    board.setSpeed(10);
    board.play();
    const missing: number[] = [];
    board.subscribe(() => {
      if (board.values.latestReading("agv", "base/speed") === undefined) missing.push(board.us);
    });
    await play(2000);
    expect((board.us - THEN) / S).toBeCloseTo(70, 0);
    expect(missing).toEqual([]);
    expect(source.asked.map(({ fromUs }) => (fromUs - THEN) / S)).toEqual([40, 60, 80, 100, 120, 140]);
    board.pause();
    const stood = board.us;
    await play(500);
    expect(board.us).toBe(stood);
  });

  test("steps from where it stands, and playing ends with a step", async () => {
    const { board, play } = boardAt(THEN);
    board.play();
    await play(1000);
    board.step(-S);
    expect(board.playing).toBe(false);
    expect((board.us - THEN) / S).toBeCloseTo(0, 1);
  });

  test("stops at the newest and says so; a later moment is the newest", async () => {
    const { board, play, hands } = boardAt(NOW - 3 * S);
    board.values.watchChannel("agv", "base/speed", () => undefined);
    await settle();
    board.setSpeed(10);
    board.play();
    await play(1000);
    expect([board.playing, board.isAtEnd]).toEqual([false, true]);
    board.seek(THEN);
    expect(board.isAtEnd).toBe(false);
    board.seek(NOW + 5 * MINUTE);
    expect(board.isAtEnd).toBe(true);
    expect(board.us).toBeLessThan(hands.wallUs());
  });

  test("before the first and long after the last sample nothing was recorded, which it says", async () => {
    const source = new Recorder(THEN, THEN + MINUTE);
    const { board } = boardAt(THEN - 5 * MINUTE, source);
    board.values.watchChannel("agv", "base/speed", () => undefined);
    await settle();
    expect([board.state, board.values.latestReading("agv", "base/speed")]).toEqual(["silent", undefined]);
    board.seek(THEN + 10 * MINUTE);
    await settle();
    const reading = board.values.latestReading("agv", "base/speed");
    // The last one is told with its age: it is stale, and looks it.
    expect([board.state, reading?.value, reading && board.values.ageS(reading)]).toEqual(["silent", 59, 541]);
  });

  test("a hub that does not answer is said, and asked again", async () => {
    const source = new Recorder();
    source.broken = true;
    const { board } = boardAt(THEN, source);
    board.values.watchChannel("agv", "base/speed", () => undefined);
    await settle();
    expect(board.state).toBe("failed");
    source.broken = false;
    board.retry();
    await settle();
    expect(board.state).toBe("ready");
  });

  test("who scrubs asks for where it stands, not for all between", async () => {
    const { board, source } = boardAt(THEN);
    board.values.watchChannel("agv", "base/speed", () => undefined);
    await settle();
    for (let i = 1; i <= 40; i += 1) board.seek(THEN + i * MINUTE);
    await settle();
    expect(board.values.latestReading("agv", "base/speed")?.value).toBe(2400);
    // Where it stood, the first on the way, and the last: one is under way at a time.
    expect(source.asked.map(({ fromUs }) => (fromUs - THEN) / MINUTE)).toEqual([0, 1, 40]);
  });

  test("charts end at the moment, forwards and back", async () => {
    const { board } = boardAt(THEN + 90 * S);
    board.feed.setLength(MINUTE);
    board.feed.subscribeSignals([SIGNAL]);
    await settle();
    const { trace } = board.feed.channelOf("base/speed");
    const last = (): number | undefined => trace.times.at(-1);
    expect([last(), trace.newest]).toEqual([THEN + 90 * S, 90]);
    const drawn = trace.columnsAt(S).length;
    const before = trace.version;
    board.seek(THEN + 70 * S);
    expect([last(), trace.newest, trace.columnsAt(S).length]).toEqual([THEN + 70 * S, 70, drawn - 20]);
    expect(trace.version).not.toBe(before);
    expect(board.feed.currentWindow()).toEqual({ fromUs: THEN + 10 * S, toUs: THEN + 70 * S });
    expect(board.feed.ageS("base/speed")).toBe(0);
  });

  test("a trail hears the last position first, then each one that the moment comes to", async () => {
    const { board, play } = boardAt(THEN + 10.5 * S);
    const heard: Batch[] = [];
    board.replayChannels("agv", ["base/x", "base/y"], (batch) => heard.push(batch));
    await settle();
    expect([...(heard[0]?.columns.value ?? [])]).toEqual([10, 10]);
    expect(heard[0]?.first).toBe(true);
    board.setSpeed(5);
    board.play();
    await play(1000);
    expect(heard.slice(1).flatMap(({ columns }) => [...columns.value])).toEqual([11, 11, 12, 12, 13, 13, 14, 14, 15, 15]);
  });
});

describe("the moment in an address", () => {
  test("goes there and back, and what is no time is said", () => {
    const at = Date.UTC(2026, 2, 29, 21, 15, 3, 250) * 1000;
    expect(readBoardQuery("?at=2026-03-29T23:15:03.250%2B02:00").at).toBe(at);
    expect(readBoardQuery(`?${writeBoardQuery({ at })}`).at).toBe(at);
    expect(momentText(at)).toBe("2026-03-29T21:15:03.250Z");
    expect(readBoardQuery("?at=2026-03-29T21:15").at).toBe(Date.UTC(2026, 2, 29, 21, 15) * 1000);
    expect(readBoardQuery("?at=yesterday")).toMatchObject({ at: null, wrongAt: "yesterday" });
    expect(readBoardQuery("?at=2026-13-45T99:00Z")).toMatchObject({ at: null, wrongAt: "2026-13-45T99:00Z" });
    expect(readBoardQuery("")).toMatchObject({ at: null, wrongAt: "" });
  });

  test("stands on the bar: it ends now while it can", () => {
    expect(barSpan(NOW - MINUTE, NOW, 10 * MINUTE)).toEqual({ fromUs: NOW - 10 * MINUTE, toUs: NOW });
    expect(barSpan(THEN, NOW, 10 * MINUTE)).toEqual({ fromUs: THEN - 5 * MINUTE, toUs: THEN + 5 * MINUTE });
  });
});
