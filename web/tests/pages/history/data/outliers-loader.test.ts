import { expect, test } from "vitest";
import { OutliersLoader } from "../../../../src/pages/history/data/outliers-loader.js";
import type { OutlierList } from "../../../../src/generated/api.js";

const SPAN = { fromUs: 0, toUs: 1000 };

function hub(): { asked: string[]; loader: OutliersLoader; answer: (() => void)[]; stopped: () => number } {
  const asked: string[] = [];
  const answer: (() => void)[] = [];
  let stopped = 0;
  const finding = {
    outliers: (site: string, channels: readonly string[], span: { fromUs: number; toUs: number }, k: number, signal?: AbortSignal) => {
      asked.push(`${site} ${channels.join()} ${String(span.fromUs)}-${String(span.toUs)} ${String(k)}`);
      signal?.addEventListener("abort", () => (stopped += 1));
      return new Promise<OutlierList>((done) => {
        answer.push(() => {
          const outlier = { samples: 9, stored: 9, first: 1, third: 2, low: 0, high: 3, count: 4, exact: true };
          done({ outliers: channels.map((address) => ({ address, ...outlier })) });
        });
      });
    },
  };
  return { asked, loader: new OutliersLoader(finding, () => undefined), answer, stopped: () => stopped };
}

const settled = async (): Promise<void> => {
  for (let i = 0; i < 5; i += 1) await Promise.resolve();
};

test("what the hub found is said of its window, and of one that is hardly another", async () => {
  const { loader, answer } = hub();
  loader.loadOutliers("agv", ["a"], SPAN, 1.5, false);
  expect(loader.foundIn("agv", SPAN, 1.5).size).toBe(0);
  answer[0]?.();
  await settled();
  expect(loader.foundIn("agv", SPAN, 1.5).get("a")?.count).toBe(4);
  expect(loader.foundIn("agv", { fromUs: 50, toUs: 1050 }, 1.5).size).toBe(1);
  expect(loader.foundIn("agv", { fromUs: 200, toUs: 1200 }, 1.5).size).toBe(0);
  expect(loader.foundIn("agv", SPAN, 2).size).toBe(0);
  expect(loader.foundIn("obs", SPAN, 1.5).size).toBe(0);
});

test("nothing is asked while no outliers are wanted, or the charts hold every sample", () => {
  const { loader, asked } = hub();
  loader.loadOutliers("agv", ["a"], SPAN, 0, false);
  loader.loadOutliers("agv", [], SPAN, 1.5, false);
  expect(asked).toEqual([]);
});

test("a window that goes with the time is looked at again once it has moved a little", async () => {
  const { loader, asked, answer } = hub();
  loader.loadOutliers("agv", ["a"], SPAN, 1.5, true);
  answer[0]?.();
  await settled();
  loader.loadOutliers("agv", ["a"], { fromUs: 20, toUs: 1020 }, 1.5, true);
  expect(asked).toHaveLength(1);
  loader.loadOutliers("agv", ["a"], { fromUs: 60, toUs: 1060 }, 1.5, true);
  expect(asked).toEqual(["agv a 0-1000 1.5", "agv a 60-1060 1.5"]);
});

test("what nobody wants any more is given up", () => {
  const { loader, stopped } = hub();
  loader.loadOutliers("agv", ["a"], SPAN, 1.5, false);
  loader.loadOutliers("agv", ["a"], SPAN, 3, false);
  expect(stopped()).toBe(1);
  loader.loadOutliers("agv", ["a"], SPAN, 0, false);
  expect(stopped()).toBe(2);
});
