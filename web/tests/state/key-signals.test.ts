import { describe, expect, test } from "vitest";
import { keySignals } from "../../src/state/key-signals.js";
import { Session } from "../../src/state/session.js";
import type { DeviceInfo, SignalInfo } from "../../src/wire/api-types.js";
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
describe("key signals", () => {
  const signal = (address: string, change: Partial<SignalInfo> = {}): SignalInfo => ({
    id: address, address, name: address, type: "number", role: "none", unit: "", decimals: -1, minimum: null, maximum: null,
    states: [], meanings: [], frame: "local", max_age: 5, primary: true, public: false, channels: [address], ...change,
  });
  const device = (signals: SignalInfo[]): DeviceInfo => ({
    id: "", name: "", kind: "other", signals, streams: [], commands: [], drive: null, public: false, link_loss: "", pointing: null, slew: null, unguarded: false, rights: ["view"],
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
