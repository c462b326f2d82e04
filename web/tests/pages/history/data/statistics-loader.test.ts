import { describe, expect, it } from "vitest";
import { comparedDaysText, ghostUs } from "../../../../src/pages/history/history-query.js";
import { StatisticsLoader } from "../../../../src/pages/history/data/statistics-loader.js";
import { ZoneClock } from "../../../../src/series/zone-clock.js";
import type { StatisticsList, StatisticsShape } from "../../../../src/generated/api.js";

const madrid = new ZoneClock("Europe/Madrid");
const HOUR = 3600e6;
function noon(day: string): { fromUs: number; toUs: number } {
  const fromUs = madrid.fromInput(`${day}T12:00:00`);
  return { fromUs, toUs: fromUs + HOUR };
}
describe("another day to compare with", () => {
  it("lies whole days away by the clock on the wall, also across summer time", () => {
    expect(ghostUs(noon("2026-11-21"), { versus: 1, shiftUs: 0 }, madrid)).toBe(24 * HOUR);
    expect(ghostUs(noon("2026-11-21"), { versus: 7, shiftUs: 0 }, madrid)).toBe(7 * 24 * HOUR);
    // The night to 25 October 2026 has an hour more, that to 29 March 2026 one less.
    expect(ghostUs(noon("2026-10-25"), { versus: 1, shiftUs: 0 }, madrid)).toBe(25 * HOUR);
    expect(ghostUs(noon("2026-03-29"), { versus: 1, shiftUs: 0 }, madrid)).toBe(23 * HOUR);
    expect(ghostUs(noon("2026-11-21"), { versus: -1, shiftUs: 0 }, madrid)).toBe(-24 * HOUR);
    expect(ghostUs(noon("2026-11-21"), { versus: 0, shiftUs: 0 }, madrid)).toBe(0);
    expect(ghostUs(noon("2026-11-21"), { versus: 1, shiftUs: 5 }, madrid)).toBe(5);
  });

  it("is said in words", () => {
    expect([1, 28, -1, -3].map(comparedDaysText)).toEqual(["1 day before", "28 days before", "1 day after", "3 days after"]);
  });
});

describe("statistics of the window", () => {
  const entry: StatisticsShape = { address: "a", count: 3, numbers: 3, low: null, high: null, mean: 1, deviation: 0, first: null, last: null, gap_us: 0 };

  function hub(): { loader: StatisticsLoader; asked: number[]; answer: () => Promise<void> } {
    const asked: number[] = [];
    let resolve: (list: StatisticsList) => void = () => undefined;
    const statistics = (_site: string, _channels: readonly string[], { toUs }: { toUs: number }): Promise<StatisticsList> => {
      asked.push(toUs);
      return new Promise((done) => {
        resolve = done;
      });
    };
    const answer = async (): Promise<void> => {
      resolve({ statistics: [entry] });
      for (let turn = 0; turn < 5; turn += 1) await Promise.resolve();
    };
    return { loader: new StatisticsLoader({ statistics }, () => undefined), asked, answer };
  }

  it("are those of the window that is shown, not of one from before", async () => {
    const { loader, answer } = hub();
    loader.loadStatistics("agv", ["a"], { fromUs: 0, toUs: 1000 }, false);
    await answer();
    expect(loader.numbersOf("agv", { fromUs: 0, toUs: 1000 }).get("a")).toEqual(entry);
    expect(loader.numbersOf("agv", { fromUs: 500, toUs: 1500 }).size).toBe(0);
    expect(loader.numbersOf("other", { fromUs: 0, toUs: 1000 }).size).toBe(0);
  });

  it("are not counted anew at each small step of a window that follows", async () => {
    const { loader, asked, answer } = hub();
    for (const step of [0, 2, 4, 6, 8, 10]) {
      loader.loadStatistics("agv", ["a"], { fromUs: step, toUs: 1000 + step }, true);
      await answer();
    }
    expect(asked).toEqual([1000, 1010]);
  });
});
