import { describe, expect, test } from "vitest";
import { keySignals } from "../../src/state/key-signals.js";
import { LiveValues, type LiveFeed } from "../../src/state/live-values.js";
import { Session } from "../../src/state/session.js";
import { Sites } from "../../src/state/sites.js";
import { ThemeChoice } from "../../src/state/theme.js";
import type { DeviceInfo, SignalInfo, SiteDetail, SiteRow } from "../../src/wire/api-types.js";
import { HubApi } from "../../src/wire/hub-api.js";
import type { Batch } from "../../src/wire/subscriptions.js";

const json = (value: unknown, status = 200): Response => new Response(JSON.stringify(value), { status });
const row: SiteRow = {
  site: "agv", name: "House vehicle", zone: "UTC", online: true, since_us: 1, last_seen_us: 1, devices: 1, signals: 2,
  why: "", loop_ms: 0, skew_ms: 0, rival_us: 0, stale: 0,
};
const news = { t: "site", site: "agv", online: true, since_us: 9, catalogue: "", loop_ms: 0, skew_ms: 0, why: "", rival_us: 0 } as const;
const detail: SiteDetail = { site: "agv", name: "House vehicle", zone: "UTC", online: true, since_us: 1, last_seen_us: 1, catalogue: "1", place: null, rules: [], enclosures: [], devices: [] };

function hub(answer: (path: string) => Response): { api: HubApi; asked: string[] } {
  const asked: string[] = [];
  const api = new HubApi((input) => {
    const path = input instanceof Request ? input.url : input.toString();
    asked.push(path);
    return Promise.resolve(answer(path));
  });
  return { api, asked };
}

describe("the session", () => {
  test("is unknown, then somebody's, then nobody's", async () => {
    const session = new Session(hub((path) => (path === "/api/logout" ? json(null) : json({ name: "ana", role: "admin" }))).api);
    const states: string[] = [session.state];
    session.subscribe(() => states.push(session.isSigningOut ? "leaving" : session.state));
    await session.refresh();
    await session.refresh();
    await session.logout();
    expect(states).toEqual(["unknown", "known", "leaving", "nobody"]);
  });

  test("is nobody's when the hub says 401", async () => {
    const session = new Session(hub(() => json({ code: "nobody", message: "" }, 401)).api);
    await session.refresh();
    expect(session.state).toBe("nobody");
  });

  test("may exist where somebody signed in before, and no more once the hub says 401", async () => {
    const notes = new Map<string, string>();
    const storage = {
      getItem: (key: string) => notes.get(key) ?? null,
      setItem: (key: string, value: string) => void notes.set(key, value),
      removeItem: (key: string) => void notes.delete(key),
    };
    let status = 200;
    const { api } = hub(() => json({ name: "ana", role: "admin" }, status));
    expect(new Session(api, storage).mayExist).toBe(false);
    const session = new Session(api, storage);
    await session.refresh();
    expect(new Session(api, storage).mayExist).toBe(true);
    status = 401;
    await session.refresh();
    expect(session.mayExist).toBe(false);
  });

  test("may always exist in a browser that forbids storage", () => {
    expect(new Session(hub(() => json(null)).api, null).mayExist).toBe(true);
  });

  test("ends here also when the hub can not be told", async () => {
    const session = new Session(hub((path) => (path === "/api/logout" ? json({}, 503) : json({ name: "ana", role: "guest" }))).api);
    await session.refresh();
    await expect(session.logout()).rejects.toThrow();
    expect(session.state).toBe("nobody");
  });
});

describe("sites", () => {
  test("follow the hub's news", async () => {
    const sites = new Sites(hub(() => json([row])).api);
    await sites.load();
    sites.applyUpdate({ ...news, online: false, since_us: 50 });
    expect(sites.siteRow("agv")).toMatchObject({ online: false, since_us: 50, last_seen_us: 50 });
  });

  test("are asked for anew when one appears that was not there", async () => {
    const { api, asked } = hub(() => json([row]));
    const sites = new Sites(api);
    await sites.load();
    sites.applyUpdate({ ...news, site: "dome" });
    expect(asked).toEqual(["/api/sites", "/api/sites"]);
  });

  test("keep the old list on screen when a new one can not be had", async () => {
    let well = true;
    const sites = new Sites(hub(() => (well ? json([row]) : json({}, 503))).api);
    await sites.load();
    well = false;
    await sites.load();
    expect([sites.status, sites.list.length]).toEqual(["failed", 1]);
  });

  test("hold a description until it changes", async () => {
    const { api, asked } = hub((path) => json(path === "/api/sites" ? [row] : detail));
    const sites = new Sites(api);
    await sites.load();
    await sites.loadDetail("agv");
    await sites.loadDetail("agv");
    sites.applyUpdate({ ...news, catalogue: "2" });
    await sites.loadDetail("agv");
    expect(asked.filter((path) => path === "/api/sites/agv")).toHaveLength(2);
  });

  test("do not remember a description that failed to load", async () => {
    let well = false;
    const sites = new Sites(hub(() => (well ? json(detail) : json({}, 500))).api);
    await expect(sites.loadDetail("agv")).rejects.toThrow();
    well = true;
    await expect(sites.loadDetail("agv")).resolves.toEqual(detail);
  });
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
  const microtask = (): Promise<void> => Promise.resolve();

  test("of many elements are one subscription", async () => {
    const feed = new HandFeed();
    const live = new LiveValues(feed);
    live.watchChannel("agv", "b/x", () => undefined);
    live.watchChannel("agv", "a/y", () => undefined);
    live.watchChannel("agv", "a/y", () => undefined);
    await microtask();
    expect(feed.open.map((entry) => entry.channels)).toEqual([["a/y", "b/x"]]);
  });

  test("are no longer asked for when the last element has gone", async () => {
    const feed = new HandFeed();
    const live = new LiveValues(feed);
    const stops = [live.watchChannel("agv", "a/y", () => undefined), live.watchChannel("agv", "a/y", () => undefined)];
    await microtask();
    stops[0]?.();
    stops[0]?.();
    await microtask();
    expect(feed.open).toHaveLength(1);
    stops[1]?.();
    await microtask();
    expect(feed.open).toEqual([]);
  });

  test("that were old when they came are old at once", async () => {
    const feed = new HandFeed();
    let now = 10_000;
    const live = new LiveValues(feed, () => now);
    live.watchChannel("agv", "a/y", () => undefined);
    await microtask();
    feed.say(0, 5, 1.5, [7000]);
    now += 500;
    const reading = live.latestReading("agv", "a/y");
    expect(reading && live.ageS(reading)).toBeCloseTo(7.5);
  });

  test("never go back in time", async () => {
    const feed = new HandFeed();
    const live = new LiveValues(feed, () => 0);
    let calls = 0;
    live.watchChannel("agv", "a/y", () => (calls += 1));
    await microtask();
    feed.say(0, 20, 2);
    feed.say(0, 10, 1);
    expect([live.latestReading("agv", "a/y")?.value, calls]).toEqual([2, 1]);
  });

  test("with an index outside the list are passed over", async () => {
    const feed = new HandFeed();
    const live = new LiveValues(feed, () => 0);
    live.watchChannel("agv", "a/y", () => undefined);
    await microtask();
    feed.say(4, 20, 2);
    expect(live.latestReading("agv", "a/y")).toBeUndefined();
  });
});

describe("key signals", () => {
  const signal = (address: string, change: Partial<SignalInfo> = {}): SignalInfo => ({
    id: address, address, name: address, type: "number", unit: "", decimals: -1, minimum: null, maximum: null,
    states: [], frame: "local", max_age: 5, primary: true, public: false, channels: [address], ...change,
  });
  const device = (signals: SignalInfo[]): DeviceInfo => ({
    id: "", name: "", kind: "other", signals, streams: [], commands: [], drive: null, public: false, link_loss: "", pointing: null, unguarded: false, rights: ["view"],
  });

  test("come from every device in turn, without positions and minor ones", () => {
    const chosen = keySignals(
      [
        device([signal("a1"), signal("a2", { primary: false }), signal("a3"), signal("a4")]),
        device([signal("b1", { type: "position" }), signal("b2")]),
      ],
      3,
    );
    expect(chosen.map((signal) => signal.address)).toEqual(["a1", "b2", "a3"]);
  });

  test("are none where there is nothing", () => {
    expect(keySignals([], 4)).toEqual([]);
  });
});

describe("the theme", () => {
  const root = (): { attributes: Map<string, string>; setAttribute(k: string, v: string): void; removeAttribute(k: string): void } => {
    const attributes = new Map<string, string>();
    return {
      attributes,
      setAttribute: (name, value) => attributes.set(name, value),
      removeAttribute: (name) => attributes.delete(name),
    };
  };

  test("is kept, and given up for the machine's own", () => {
    const kept = new Map<string, string>();
    const storage = { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, value: string) => void kept.set(key, value) };
    new ThemeChoice(root(), storage).setTheme("night");
    const again = root();
    const theme = new ThemeChoice(again, storage);
    expect([theme.theme, again.attributes.get("data-theme")]).toEqual(["night", "night"]);
    theme.setTheme("auto");
    expect(again.attributes.size).toBe(0);
  });

  test("falls back to the machine's own when what was kept means nothing", () => {
    expect(new ThemeChoice(root(), { getItem: () => "pink", setItem: () => undefined }).theme).toBe("auto");
  });
});

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
