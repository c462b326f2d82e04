import { describe, expect, test } from "vitest";
import { Session } from "../../src/state/session.js";
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

  test("that ended waits for the same person; what was asked meanwhile is asked again then", async () => {
    let here: string | null = "ana";
    const { api } = hub(() => (here === null ? json({ code: "unauthorized", message: "" }, 401) : json({ name: here, role: "crew" })));
    const session = new Session(api);
    await session.refresh();
    const rights = session.rightsKey;
    here = null;
    await session.refresh();
    expect([session.state, session.person?.name, session.rightsKey]).toEqual(["ended", "ana", rights]);
    const asked = session.waitUntilBack();
    here = "ana";
    await session.login("ana", "password");
    expect([session.state, await asked]).toEqual(["known", true]);
  });

  test("that ended shows nobody else what it showed, and waits for nobody who has left", async () => {
    let here: string | null = "ana";
    const { api } = hub(() => (here === null ? json({ code: "unauthorized", message: "" }, 401) : json({ name: here, role: "crew" })));
    const session = new Session(api);
    let others = 0;
    session.onOtherPerson = () => (others += 1);
    await session.refresh();
    here = null;
    await session.refresh();
    here = "bea";
    await session.login("bea", "password");
    expect([session.state, session.person?.name, others]).toEqual(["ended", "ana", 1]);
    const asked = session.waitUntilBack();
    session.forget();
    expect([session.state, session.person, await asked]).toEqual(["nobody", null, false]);
  });

  test("of a display ends for good: its screen goes dark", async () => {
    let status = 200;
    const session = new Session(hub(() => json({ name: "Hall", role: "display" }, status)).api);
    await session.refresh();
    status = 401;
    await session.refresh();
    expect([session.state, session.person]).toEqual(["nobody", null]);
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
