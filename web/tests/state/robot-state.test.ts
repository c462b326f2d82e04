import { expect, test } from "vitest";
import { RobotState } from "../../src/state/robot-state.js";
import { FakeLine } from "../controllers/drive/fake-connection.js";

const at = { site: "agv", device: "base" } as const;

function told(): { line: FakeLine; news: RobotState } {
  const line = new FakeLine();
  const news = new RobotState(line);
  line.say({ t: "stop_news", ...at, latched: true, confirmed: true, who: "Ada", time_us: 1, id: "x" });
  const nobodyAsks = { rival: "", asking: false, answer_ms: 0, refused: "", forceable: false };
  line.say({ t: "lease_news", ...at, holder: "Ada", yours: false, epoch: 0, remains_ms: 1, ...nobodyAsks });
  return { line, news };
}

test("a page that is opened later learns what was said before", () => {
  const { news } = told();
  expect(news.stopOf("agv", "base")?.latched).toBe(true);
  expect(news.leaseOf("agv", "base")?.holder).toBe("Ada");
  expect(news.stopOf("agv", "arm")).toBeUndefined();
});

test("nothing is remembered over a lost connection", () => {
  const { line, news } = told();
  line.become("lost");
  expect(news.stopOf("agv", "base")).toBeUndefined();
  expect(news.leaseOf("agv", "base")).toBeUndefined();
});

test("nothing is remembered of a site that went offline", () => {
  const { line, news } = told();
  line.say({ t: "site", site: "agv", online: false, since_us: 0, catalogue: "", loop_ms: 0, skew_ms: 0, why: "", rival_us: 0, away: false });
  expect(news.stopOf("agv", "base")).toBeUndefined();
});

test("a device is held when one of the leases is ours", () => {
  const { line, news } = told();
  expect(news.holdsAny()).toBe(false);
  line.say({ t: "lease_news", ...at, device: "arm", holder: "me", yours: true, epoch: 3, remains_ms: 1, rival: "", asking: false, answer_ms: 0, refused: "", forceable: false });
  expect(news.holdsAny()).toBe(true);
  line.become("lost");
  expect(news.holdsAny()).toBe(false);
});
