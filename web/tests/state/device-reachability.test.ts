import { beforeEach, expect, test } from "vitest";
import type { DeviceUpdate } from "../../src/generated/wire.js";
import { DeviceReachability } from "../../src/state/device-reachability.js";
import { FakeLine } from "../controllers/drive/fake-connection.js";

let line: FakeLine;
let reach: DeviceReachability;
beforeEach(() => {
  line = new FakeLine();
  reach = new DeviceReachability(line);
});

function lost(device: string, more: Partial<DeviceUpdate> = {}): DeviceUpdate {
  return { t: "device_news", site: "obs", device, reached: false, why: "nobody answers", since_us: 1, ...more };
}

test("a device that is not reached has its reason until it is back", () => {
  let told = 0;
  reach.subscribe(() => told++);
  line.say(lost("dome"));
  expect(reach.unreachableSince("obs", "dome")?.why).toBe("nobody answers");
  expect(reach.unreachableSince("obs", "mount")).toBeUndefined();
  expect(reach.unreachableSince("agv", "dome")).toBeUndefined();
  line.say(lost("dome", { reached: true, why: "" }));
  expect(reach.unreachableSince("obs", "dome")).toBeUndefined();
  expect(told).toBe(2);
});

test("without the gateway or the hub nothing is held against a device", () => {
  line.say(lost("dome"));
  line.say({ t: "site", site: "agv", online: false, since_us: 1, catalogue: "", loop_ms: 0, skew_ms: 0, why: "", rival_us: 0, away: false });
  expect(reach.unreachableSince("obs", "dome")).toBeDefined();
  line.say({ t: "site", site: "obs", online: false, since_us: 1, catalogue: "", loop_ms: 0, skew_ms: 0, why: "", rival_us: 0, away: false });
  expect(reach.unreachableSince("obs", "dome")).toBeUndefined();
  line.say(lost("dome"));
  line.become("lost");
  expect(reach.unreachableSince("obs", "dome")).toBeUndefined();
});
