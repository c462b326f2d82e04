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
  readonly asked: { channels: readonly string[]; fromUs: number; toUs: number; width: number }[] = [];
  /** Moments of which only the last values were asked for. */
  readonly moments: { channels: readonly string[]; us: number }[] = [];
  broken = false;
  constructor(readonly fromUs = THEN - 10 * MINUTE, readonly toUs = NOW) {}

  history(_site: string, { channels, fromUs, toUs, width }: HistoryQuery): Promise<HistoryAnswer> {
    this.asked.push({ channels, fromUs, toUs, width });
    if (this.broken) return Promise.reject(new Error("down"));
    const times: number[] = [];
    for (let us = Math.ceil(Math.max(this.fromUs, fromUs) / S) * S; us < Math.min(this.toUs, toUs); us += S) times.push(us);
    return Promise.resolve({
      series: channels.map((address) => ({
        address, kind: "exact" as const, t_us: times, v: times.map((us) => (address === "base/word" ? null : (us - THEN) / S)), gaps: [],
        ...(address === "base/word" ? { text: times.map((us) => `second ${String((us - THEN) / S)}`) } : {}),
      })),
    });
  }

  lastValues(_site: string, channels: readonly string[], beforeUs: number): Promise<ValueList> {
    this.moments.push({ channels, us: beforeUs - 1 });
    if (this.broken) return Promise.reject(new Error("down"));
    const t = Math.min(Math.ceil(beforeUs / S) * S, this.toUs) - S;
    return Promise.resolve({ values: t < this.fromUs ? [] : channels.map((address) => ({ address, t_us: t, v: address === "base/word" ? null : (t - THEN) / S, ...(address === "base/word" ? { text: `second ${String((t - THEN) / S)}` } : {}) })) });
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

  test("asks for all signals of the moment at once, then for what is around it, and then for nothing more", async () => {
    const { board, source, play } = boardAt(THEN);
    for (let i = 0; i < 20; i += 1) board.values.watchChannel("agv", `base/s${String(i)}`, () => undefined);
    await settle();
    expect([source.asked, source.moments.map(({ channels, us }) => [channels.length, us])]).toEqual([[], [[20, THEN]]]);
    await play(200);
    expect(source.asked.map(({ channels }) => channels.length)).toEqual([20]);
    // The last before the stretch, too.
    expect(source.moments).toHaveLength(2);
    board.step(3 * S);
    board.step(-2 * S);
    await play(200);
    expect(board.values.latestReading("agv", "base/s3")?.value).toBe(1);
    expect([source.asked.length, source.moments.length]).toEqual([1, 2]);
  });

  test("an answer for another moment is not shown, nor for other signals", async () => {
    const { board } = boardAt(THEN + 10 * S);
    board.values.watchChannel("agv", "base/speed", () => undefined);
    await Promise.resolve();
    board.seek(THEN + 300 * S);
    await settle();
    expect(board.values.latestReading("agv", "base/speed")?.value).toBe(300);
    board.values.watchChannel("agv", "base/more", () => undefined);
    expect([board.values.isReady(board.us), board.values.latestReading("agv", "base/more")]).toEqual([false, undefined]);
    await settle();
    expect(board.values.latestReading("agv", "base/more")?.value).toBe(300);
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
    // It waits for what comes with the first question, and for nothing after that.
    expect((board.us - THEN) / S).toBe(69.5);
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
    const { board, play } = boardAt(THEN, source);
    board.values.watchChannel("agv", "base/speed", () => undefined);
    await settle();
    expect(board.state).toBe("failed");
    source.broken = false;
    board.retry();
    await settle();
    expect(board.state).toBe("ready");
    source.broken = true;
    await play(300);
    expect(board.state).toBe("failed");
  });

  test("who scrubs asks for where it stands, not for all between", async () => {
    const { board, source } = boardAt(THEN);
    board.values.watchChannel("agv", "base/speed", () => undefined);
    await settle();
    for (let i = 1; i <= 40; i += 1) board.seek(THEN + i * MINUTE);
    await settle();
    expect(board.values.latestReading("agv", "base/speed")?.value).toBe(2400);
    // Where it stood, the first on the way, and the last: one is under way at a time.
    expect(source.moments.map(({ us }) => (us - THEN) / MINUTE)).toEqual([0, 1, 40]);
    expect(source.asked).toEqual([]);
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

  test("charts ask for as many points as the widest one has pixels, in steps, and keep what they have when it is narrower", async () => {
    const { board, source } = boardAt(THEN + 90 * S);
    board.feed.setWidth(430);
    board.feed.subscribeSignals([SIGNAL]);
    await settle();
    const points = (): number[] => source.asked.map(({ width, fromUs, toUs }) => Math.round((width * 5 * MINUTE) / (toUs - fromUs)));
    expect(points().every((each) => each >= 500 && each < 510)).toBe(true);
    const asked = source.asked.length;
    board.feed.setWidth(300);
    board.feed.setWidth(480);
    await settle();
    expect(source.asked.length).toBe(asked);
    board.feed.setWidth(Infinity);
    await settle();
    expect(points().at(-1)).toBeGreaterThanOrEqual(800);
  });

  test("charts stay as they are for a blink after a jump, until theirs has come; not while a hand goes on", async () => {
    const { board, play } = boardAt(THEN);
    board.feed.subscribeSignals([SIGNAL]);
    await settle();
    await play(200);
    const held: boolean[] = [board.holdsCharts];
    board.seek(THEN + 20 * MINUTE);
    held.push(board.holdsCharts);
    await settle();
    held.push(board.holdsCharts);
    board.seek(THEN + 40 * MINUTE);
    held.push(board.holdsCharts);
    expect(held).toEqual([false, true, false, false]);
    const silent = new PastBoard("agv", { history: () => new Promise(() => undefined), lastValues: () => new Promise(() => undefined) }, THEN, new Hands());
    silent.feed.subscribeSignals([SIGNAL]);
    silent.seek(THEN + MINUTE);
    expect(silent.holdsCharts).toBe(true);
  });

  test("a chart's window is one question, and going on a little asks for the rest alone", async () => {
    const { board, source } = boardAt(THEN + 10 * S);
    board.feed.subscribeSignals([SIGNAL]);
    await settle();
    // Five minutes in parts of 37.5 s, of which one sticks out.
    expect(source.asked.map(({ fromUs, toUs }) => [(fromUs - THEN) / S, (toUs - THEN) / S])).toEqual([[-300, 37.5]]);
    board.seek(THEN + 100 * S);
    await settle();
    expect(source.asked.slice(1).map(({ fromUs, toUs }) => [(fromUs - THEN) / S, (toUs - THEN) / S])).toEqual([[37.5, 112.5]]);
    const { times } = board.feed.channelOf("base/speed").trace;
    expect([times[0], times.length]).toEqual([THEN - 225 * S, 326]);
    expect([...times].map((us) => (us - THEN) / S)).toEqual(Array.from({ length: 326 }, (_, i) => i - 225));
  });

  test("a signal that comes once a minute has no gap where parts of the window meet, and a gap over several is one", async () => {
    const gap = { from_us: THEN - 200 * S, to_us: THEN - 90 * S, reason: "link" };
    const source: PastSource = {
      history: (_site, { channels, fromUs, toUs }) => {
        const times = [0, 1, 2, 3, 4].map((i) => THEN - i * MINUTE).filter((us) => us >= fromUs && us <= toUs).reverse();
        return Promise.resolve({ series: channels.map((address) => ({ address, kind: "exact" as const, t_us: times, v: times.map(() => 1), gaps: [gap] })) });
      },
      lastValues: () => Promise.resolve({ values: [] }),
    };
    const board = new PastBoard("agv", source, THEN, new Hands());
    board.feed.subscribeSignals([SIGNAL]);
    await settle();
    const { trace, gaps } = board.feed.channelOf("base/speed");
    expect([...trace.times]).toEqual([THEN - 4 * MINUTE, gap.from_us + 1, THEN - 3 * MINUTE, THEN - 2 * MINUTE, THEN - MINUTE, THEN]);
    expect([...trace.values]).toEqual([1, NaN, 1, 1, 1, 1]);
    expect(trace.allowedUs).toBe(3 * MINUTE);
    expect(gaps).toEqual([gap]);
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
