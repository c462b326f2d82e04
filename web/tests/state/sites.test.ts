import { describe, expect, test, vi } from "vitest";
import { Session } from "../../src/state/session.js";
import { Sites } from "../../src/state/sites.js";
import type { SiteShape, SiteSummary } from "../../src/generated/api.js";
import { HubApi } from "../../src/wire/hub-api.js";

const json = (value: unknown, status = 200): Response => new Response(JSON.stringify(value), { status });
const row: SiteSummary = {
  site: "agv", name: "House vehicle", zone: "UTC", online: true, since_us: 1, last_seen_us: 1, devices: 1, signals: 2,
  why: "", loop_ms: 0, skew_ms: 0, rival_us: 0, stale: 0, group: "", tags: [], state: "", battery: null, latitude: null, longitude: null, moving: false, heading: null, driver: "", stream: "", stops: [],
};
const news = { t: "site", site: "agv", online: true, since_us: 9, catalogue: "", loop_ms: 0, skew_ms: 0, why: "", rival_us: 0, away: false } as const;
const detail: SiteShape = { site: "agv", name: "House vehicle", zone: "UTC", online: true, since_us: 1, last_seen_us: 1, catalogue: "1", place: null, rules: [], enclosures: [], shown_units: {}, map: null, devices: [] };
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
describe("sites", () => {
  test("that a hub has which is away stay, and the list is asked for again until they are back", async () => {
    vi.useFakeTimers();
    let missing = "";
    const rows = [row, { ...row, site: "moon", name: "Moon" }];
    const answer = (): Response => new Response(JSON.stringify(missing === "" ? rows : rows.slice(1)), { headers: missing === "" ? {} : { "x-talaia-missing": missing } });
    const { api, asked } = hub(answer);
    const sites = new Sites(api);
    await sites.load();
    expect(sites.missing).toEqual([]);
    missing = "east,west";
    await sites.load();
    expect(sites.missing).toEqual(["east", "west"]);
    expect(sites.list.map(({ site, online }) => [site, online])).toEqual([["agv", false], ["moon", true]]);
    expect(sites.siteRow("agv")?.why).toContain("cannot be reached");
    missing = "";
    await vi.advanceTimersByTimeAsync(5000);
    expect(sites.missing).toEqual([]);
    expect(sites.siteRow("agv")?.online).toBe(true);
    await vi.advanceTimersByTimeAsync(60_000);
    expect(asked).toHaveLength(3);
    vi.useRealTimers();
  });

  test("follow the hub's news", async () => {
    const sites = new Sites(hub(() => json([row])).api);
    await sites.load();
    sites.applyUpdate({ ...news, online: false, since_us: 50 });
    expect(sites.siteRow("agv")).toMatchObject({ online: false, since_us: 50, last_seen_us: 50 });
  });

  test("say their ids where two share one name, on every page that lists them", async () => {
    const rows = [row, { ...row, site: "agv2", name: "HOUSE vehicle" }, { ...row, site: "dome", name: "Dome" }];
    const sites = new Sites(hub(() => json(rows)).api);
    await sites.load();
    expect(sites.list.map(({ name }) => name)).toEqual(["House vehicle (agv)", "HOUSE vehicle (agv2)", "Dome"]);
    sites.applyUpdate({ ...news, online: false });
    expect(sites.siteRow("agv")?.name).toBe("House vehicle (agv)");
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
test("with many sites, news of them are told together; with few, each at once", () => {
  vi.useFakeTimers();
  try {
    for (const [count, atOnce, inAll] of [[3, 3, 3], [200, 0, 1]] as const) {
      const sites = new Sites(hub(() => json([])).api);
      sites["rows"] = Array.from({ length: count }, (_, at) => ({ ...row, site: `s${String(at)}`, online: false }));
      let told = 0;
      sites.subscribe(() => {
        told += 1;
      });
      for (let at = 0; at < 3; at++) sites.applyUpdate({ ...news, site: `s${String(at)}` });
      // What is asked for is of now, whenever pages are told.
      expect([told, sites.siteRow("s2")?.online]).toEqual([atOnce, true]);
      vi.runAllTimers();
      expect(told).toBe(inAll);
    }
  } finally {
    vi.useRealTimers();
  }
});
