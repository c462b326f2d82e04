import { describe, expect, test } from "vitest";
import { LiveValues, type LiveFeed } from "../../src/state/live-values.js";
import { Session } from "../../src/state/session.js";
import { HubApi } from "../../src/wire/hub-api.js";
import type { Batch } from "../../src/wire/subscriptions.js";

const json = (value: unknown, status = 200): Response => new Response(JSON.stringify(value), { status });
function hub(answer: (path: string) => Response): { api: HubApi; asked: string[] } {
  const asked: string[] = [];
  const api = new HubApi((input) => {
    const path = input instanceof Request ? input.url : input.toString();
    asked.push(path);
    return Promise.resolve(answer(path));
  });
  return { api, asked };
}
test("what a page asks for by itself does not keep the session; staying does", async () => {
  const said: string[] = [];
  const api = new HubApi((_input, init) => {
    said.push(`${init?.method ?? ""} ${new Headers(init?.headers).get("talaia-background") ?? "-"}`);
    return Promise.resolve(json({ name: "ana", role: "admin", permissions: [], devices: [] }));
  });
  const session = new Session(api);
  await session.refresh();
  await api.devices();
  await session.extend();
  await api.request("POST", "/api/logout", {});
  expect(said).toEqual(["GET 1", "GET 1", "GET -", "POST -"]);
});
test("a page is told when what the person may do has changed, and not when only time has passed", async () => {
  let person: object = { name: "ana", role: "crew", admin: false, permissions: [{ right: "use", site: "agv", device: "*" }] };
  const session = new Session(hub(() => json(person)).api);
  await session.refresh();
  const rights = session.rightsKey;
  let told = 0;
  session.subscribe(() => (told += 1));
  person = { ...person, idle_ends_us: 7 };
  await session.refresh();
  expect([told, session.rightsKey]).toEqual([0, rights]);
  person = { ...person, permissions: [] };
  await session.refresh();
  expect(told).toBe(1);
  expect(session.rightsKey).not.toBe(rights);
});
describe("live values", () => {
  class HandFeed implements LiveFeed {
    readonly open: { site: string; channels: readonly string[]; listener: (batch: Batch) => void }[] = [];
    subscribe(site: string, channels: readonly string[], _everyMs: number, listener: (batch: Batch) => void): () => void {
      const entry = { site, channels, listener };
      this.open.push(entry);
      return () => this.open.splice(this.open.indexOf(entry), 1);
    }
    say(channel: number, timeUs: number, value: number, ageMs: number[] = []): void {
      const entry = this.open[0];
      entry?.listener({
        site: entry.site, channels: entry.channels, first: ageMs.length > 0,
        columns: { channel: Uint16Array.of(channel), timeUs: Float64Array.of(timeUs), value: Float64Array.of(value), texts: {}, ageMs },
      });
    }
  }
  /** All that was begun in this turn is done. */
  const nextTurn = (): Promise<void> => new Promise((resolve) => setTimeout(resolve, 0));

  test("of many elements are one subscription", async () => {
    const feed = new HandFeed();
    const live = new LiveValues(feed);
    live.watchChannel("agv", "b/x", () => undefined);
    live.watchChannel("agv", "a/y", () => undefined);
    live.watchChannel("agv", "a/y", () => undefined);
    await nextTurn();
    expect(feed.open.map((entry) => entry.channels)).toEqual([["a/y", "b/x"]]);
  });

  test("of elements that are drawn one after the other are one subscription, asked for once", async () => {
    const feed = new HandFeed();
    let asked = 0;
    const live = new LiveValues({
      subscribe: (...words) => {
        asked += 1;
        return feed.subscribe(...words);
      },
    });
    // As elements inside each other are: each draws its own, which come behind in microtasks.
    for (const channel of ["a/x", "a/y", "a/z"]) {
      live.watchChannel("agv", channel, () => undefined);
      await Promise.resolve();
    }
    await nextTurn();
    expect(feed.open.map((entry) => entry.channels)).toEqual([["a/x", "a/y", "a/z"]]);
    expect(asked).toBe(1);
  });

  test("are no longer asked for when the last element has gone", async () => {
    const feed = new HandFeed();
    const live = new LiveValues(feed);
    const stops = [live.watchChannel("agv", "a/y", () => undefined), live.watchChannel("agv", "a/y", () => undefined)];
    await nextTurn();
    stops[0]?.();
    stops[0]?.();
    await nextTurn();
    expect(feed.open).toHaveLength(1);
    stops[1]?.();
    await nextTurn();
    expect(feed.open).toEqual([]);
  });

  test("that were old when they came are old at once", async () => {
    const feed = new HandFeed();
    let now = 10_000;
    const live = new LiveValues(feed, () => now);
    live.watchChannel("agv", "a/y", () => undefined);
    await nextTurn();
    feed.say(0, 5, 1.5, [7000]);
    now += 500;
    const reading = live.latestReading("agv", "a/y");
    expect(reading && live.ageS(reading)).toBeCloseTo(7.5);
  });

  test("are older than the page's clock says where that stood still, and who watches is told", async () => {
    const feed = new HandFeed();
    const live = new LiveValues(feed, () => 10_000);
    let told = 0;
    live.watchChannel("agv", "a/y", () => (told += 1));
    await nextTurn();
    feed.say(0, 5, 1.5);
    live.addAge(3_600_000);
    const reading = live.latestReading("agv", "a/y");
    expect(reading && live.ageS(reading)).toBeCloseTo(3600);
    expect(told).toBe(2);
  });

  test("never go back in time", async () => {
    const feed = new HandFeed();
    const live = new LiveValues(feed, () => 0);
    let calls = 0;
    live.watchChannel("agv", "a/y", () => (calls += 1));
    await nextTurn();
    feed.say(0, 20, 2);
    feed.say(0, 10, 1);
    expect([live.latestReading("agv", "a/y")?.value, calls]).toEqual([2, 1]);
  });

  test("with an index outside the list are passed over", async () => {
    const feed = new HandFeed();
    const live = new LiveValues(feed, () => 0);
    live.watchChannel("agv", "a/y", () => undefined);
    await nextTurn();
    feed.say(4, 20, 2);
    expect(live.latestReading("agv", "a/y")).toBeUndefined();
  });
});
