import { describe, expect, it } from "vitest";
import { HistoryLoader, type WindowQuestion } from "../../../../src/pages/history/data/history-loader.js";
import type { HistoryAnswer } from "../../../../src/generated/api.js";
import type { HistoryQuery } from "../../../../src/wire/hub-api.js";

interface Asked {
  readonly query: HistoryQuery;
  readonly signal: AbortSignal | undefined;
  readonly answer: (history: HistoryAnswer) => Promise<void>;
  readonly fail: () => Promise<void>;
}

/** A hub that answers when it is told to. */
function hub(): { loader: HistoryLoader; asked: Asked[] } {
  const asked: Asked[] = [];
  const history = (_site: string, query: HistoryQuery, signal?: AbortSignal): Promise<HistoryAnswer> =>
    new Promise((resolve, reject) => {
      const later = async (act: () => void): Promise<void> => {
        act();
        // What follows an answer is done in a few turns of the loop.
        for (let turn = 0; turn < 5; turn += 1) await Promise.resolve();
      };
      const answer = (said: HistoryAnswer): Promise<void> => later(() => {
        resolve(said);
      });
      const fail = (): Promise<void> => later(() => {
        reject(new Error("down"));
      });
      asked.push({ query, signal, answer, fail });
    });
  return { loader: new HistoryLoader({ history }, () => undefined), asked };
}

const ONE: HistoryAnswer = { series: [{ address: "a", t_us: [1, 2], v: [1, 2], kind: "exact", gaps: [] }] };

function question(fromUs: number, address = "a", length = 1000): WindowQuestion {
  return { site: "agv", channels: [{ address, maxAge: 5, shown: null }], span: { fromUs, toUs: fromUs + length }, width: 100 };
}

describe("loading windows", () => {
  it("asks once for what is asked twice, with a little more on each side", () => {
    const { loader, asked } = hub();
    loader.loadHistory(question(3000), false);
    loader.loadHistory(question(3000), false);
    expect(asked.map(({ query }) => query)).toEqual([{ channels: ["a"], fromUs: 2750, toUs: 4250, width: 150 }]);
  });

  it("fills a window that is dragged while it moves, and of what was asked meanwhile asks only the last", async () => {
    const { loader, asked } = hub();
    for (const from of [1000, 1300, 1600, 1900]) loader.loadHistory(question(from), true);
    expect(asked).toHaveLength(1);
    await asked[0]?.answer(ONE);
    expect([loader.state, loader.data.get("a")?.count]).toEqual(["loading", 2]);
    expect(asked.map(({ query }) => query.fromUs)).toEqual([750, 1650]);
    await asked[1]?.answer(ONE);
    expect(loader.state).toBe("ready");
  });

  it("cancels what is of no use any more: another place in time, or other signals", () => {
    const { loader, asked } = hub();
    loader.loadHistory(question(0), false);
    loader.loadHistory(question(50_000), false);
    loader.loadHistory(question(50_000, "b"), false);
    expect(asked.map(({ signal }) => signal?.aborted)).toEqual([true, true, false]);
  });

  it("does not ask for a small move that what is there covers, but does once it rests", async () => {
    const { loader, asked } = hub();
    loader.loadHistory(question(0), false);
    await asked[0]?.answer(ONE);
    loader.loadHistory(question(200), true);
    expect(asked).toHaveLength(1);
    loader.loadHistory(question(300), true);
    expect(asked).toHaveLength(2);
    await asked[1]?.answer(ONE);
    loader.loadHistory(question(400, "a", 500), true);
    expect(asked).toHaveLength(3);
    await asked[2]?.answer(ONE);
    loader.loadHistory(question(410, "a", 500), false);
    expect(asked).toHaveLength(4);
  });

  it("keeps the old picture while it loads and when it fails, and asks again when told to", async () => {
    const { loader, asked } = hub();
    loader.loadHistory(question(0), false);
    await asked[0]?.answer(ONE);
    loader.loadHistory(question(5000), false);
    expect([loader.state, loader.data.size]).toEqual(["loading", 1]);
    await asked[1]?.fail();
    expect([loader.state, loader.data.size]).toEqual(["failed", 1]);
    loader.invalidate();
    loader.loadHistory(question(5000), false);
    await asked[2]?.answer(ONE);
    expect(loader.state).toBe("ready");
  });

  it("forgets all when nothing is chosen", async () => {
    const { loader, asked } = hub();
    loader.loadHistory(question(0), false);
    await asked[0]?.answer(ONE);
    loader.loadHistory({ ...question(0), channels: [] }, false);
    expect([loader.state, loader.data.size]).toEqual(["ready", 0]);
  });
});
