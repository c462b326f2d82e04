import { describe, expect, test } from "vitest";
import { Session } from "../../src/state/session.js";
import { ThemeChoice } from "../../src/state/theme.js";
import { HubApi } from "../../src/wire/hub-api.js";

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
