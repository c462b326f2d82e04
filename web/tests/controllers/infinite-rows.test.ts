import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { InfiniteRows, mergedRows, type RowsPage } from "../../src/controllers/infinite-rows.js";

interface Event {
  readonly id: string;
  readonly over: boolean;
}

const PAGE = 3;
const event = (id: number, over = false): Event => ({ id: String(id), over });
const ids = (rows: readonly Event[] | null): string | undefined => rows?.map(({ id }) => id).join(" ");

/** A hub whose answers come when the test says so. */
class SlowHub {
  /** How much there is: the newest has this number. */
  newest = 5;
  readonly asked: string[] = [];
  private readonly waiting: (() => void)[] = [];
  private readonly broken: Error[] = [];

  readonly find = (before: string): Promise<RowsPage<Event>> => {
    this.asked.push(before);
    const first = before === "" ? this.newest : Number(before) - 1;
    const rows = [first, first - 1, first - 2].filter((id) => id > 0).map((id) => event(id));
    return new Promise((resolve, reject) => {
      this.waiting.push(() => {
        const [error] = this.broken.splice(0, 1);
        if (error === undefined) resolve({ rows, more: first > PAGE });
        else reject(error);
      });
    });
  };

  failNext(): void {
    this.broken.push(new Error("the line is cut"));
  }

  /** Answers what was asked as number `at` of what is not answered. */
  async answer(at = 0): Promise<void> {
    this.waiting.splice(at, 1).forEach((answer) => {
      answer();
    });
    await settled();
  }
}

/** Lets all that has been answered be dealt with. */
async function settled(): Promise<void> {
  for (let turn = 0; turn < 10; turn += 1) await Promise.resolve();
}

let hub: SlowHub;
let drawn: number;
let list: InfiniteRows<Event>;

beforeEach(() => {
  vi.useFakeTimers();
  hub = new SlowHub();
  drawn = 0;
  list = new InfiniteRows(hub.find, () => {
    drawn += 1;
  });
});

afterEach(() => {
  vi.useRealTimers();
});

test("a question gives the newest, and the next page goes on from the last row", async () => {
  expect([list.hasStarted, list.loading]).toEqual([false, false]);
  list.load("all");
  expect([list.hasStarted, list.loading, list.hasMore]).toEqual([true, true, true]);
  await hub.answer();
  expect([ids(list.rows), list.loading, list.hasMore]).toEqual(["5 4 3", false, true]);
  void list.loadOlder();
  void list.loadOlder();
  await hub.answer();
  expect([ids(list.rows), list.hasMore]).toEqual(["5 4 3 2 1", false]);
  void list.loadOlder();
  expect(hub.asked).toEqual(["", "3"]);
  expect(drawn).toBeGreaterThan(3);
});

test("the same question is asked once, and another begins anew", async () => {
  list.load("all");
  list.load("all");
  await hub.answer();
  list.load("some");
  expect([ids(list.rows), list.loading]).toEqual(["", true]);
  expect(hub.asked).toEqual(["", ""]);
});

test("a run that is overtaken is dropped, whatever became of it", async () => {
  list.load("all");
  hub.newest = 2;
  list.load("some");
  await hub.answer(1);
  hub.failNext();
  await hub.answer();
  expect([ids(list.rows), list.renderFailure, list.loading]).toEqual(["2 1", null, false]);
  list.load("all");
  await hub.answer();
  void list.loadNewer();
  hub.newest = 1;
  list.load("few");
  await hub.answer(1);
  await hub.answer();
  expect(ids(list.rows)).toBe("1");
});

test("a failure stops the list until somebody tries again", async () => {
  hub.failNext();
  list.load("all");
  await hub.answer();
  expect(list.renderFailure).toBeInstanceOf(Error);
  await list.loadOlder();
  expect(hub.asked.length).toBe(1);
  list.retry();
  expect([list.renderFailure, list.loading]).toEqual([null, true]);
  await hub.answer();
  expect(ids(list.rows)).toBe("5 4 3");
});

test("what is new stands above the rest, and is looked for once for all that is told meanwhile", async () => {
  list.load("all");
  await hub.answer();
  hub.newest = 6;
  list.scheduleRefresh();
  list.scheduleRefresh();
  await vi.advanceTimersByTimeAsync(600);
  expect(hub.asked).toEqual(["", ""]);
  hub.newest = 7;
  await vi.advanceTimersByTimeAsync(600);
  // It was told of one more: that may be missing from the answer that is on its way.
  expect(hub.asked).toEqual(["", ""]);
  await hub.answer();
  expect(ids(list.rows)).toBe("6 5 4 3");
  expect(hub.asked).toEqual(["", "", ""]);
  await hub.answer();
  expect(ids(list.rows)).toBe("7 6 5 4 3");
  await vi.advanceTimersByTimeAsync(5000);
  expect(hub.asked.length).toBe(3);
});

test("news that never rest are looked for all the same", async () => {
  list.load("all");
  await hub.answer();
  hub.newest = 6;
  for (let turn = 0; turn < 30; turn += 1) {
    list.scheduleRefresh();
    await vi.advanceTimersByTimeAsync(100);
  }
  await hub.answer();
  expect(ids(list.rows)).toBe("6 5 4 3");
});

test("nothing is looked for before something was asked, nor after the list was left", async () => {
  await list.loadNewer();
  list.load("all");
  await hub.answer();
  list.scheduleRefresh();
  list.stopPolling();
  await vi.advanceTimersByTimeAsync(5000);
  expect(hub.asked).toEqual([""]);
});

test("newer ones that do not come are tried for at the next news", async () => {
  list.load("all");
  await hub.answer();
  hub.failNext();
  void list.loadNewer();
  await hub.answer();
  expect([ids(list.rows), list.renderFailure]).toEqual(["5 4 3", null]);
  hub.newest = 6;
  void list.loadNewer();
  await hub.answer();
  expect(ids(list.rows)).toBe("6 5 4 3");
});

test("where more than a page is new, the list begins anew, and an older page on its way is dropped", async () => {
  list.load("all");
  await hub.answer();
  void list.loadOlder();
  hub.newest = 20;
  void list.loadNewer();
  await hub.answer(1);
  expect([ids(list.rows), list.hasMore, list.loading]).toEqual(["20 19 18", true, false]);
  await hub.answer();
  expect(ids(list.rows)).toBe("20 19 18");
  void list.loadOlder();
  await hub.answer();
  expect(ids(list.rows)).toBe("20 19 18 17 16 15");
});

test("rows change where they stand, and go with the next news when they do not fit any more", async () => {
  list = new InfiniteRows(hub.find, () => undefined, ({ over }) => !over);
  list.load("all");
  await hub.answer();
  list.updateRows((rows) => rows.map((row) => (row.id === "3" ? { ...row, over: true } : row)));
  expect(ids(list.rows)).toBe("5 4 3");
  hub.newest = 6;
  void list.loadNewer();
  await hub.answer();
  // The hub's answer does not know of it: row 3 is not on the newest page.
  expect(ids(list.rows)).toBe("6 5 4");
});

test("of two pages each row stands once, as it was said last, and a hole between them is noticed", () => {
  expect(ids(mergedRows([event(2), event(1)], [event(3), event(2)], true))).toBe("3 2 1");
  expect(mergedRows([event(2)], [event(2, true)], true)?.[0]?.over).toBe(true);
  expect(mergedRows([event(2), event(1)], [event(90), event(89)], true)).toBeNull();
  expect(ids(mergedRows([event(2)], [event(90)], false))).toBe("90 2");
  expect(ids(mergedRows([], [event(90)], true))).toBe("90");
});
