import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import type { ToBrowser } from "../../../src/generated/wire.js";
import { GroupCommandClient } from "../../../src/controllers/drive/group-command-client.js";
import { GroupStopClient } from "../../../src/controllers/drive/group-stop-client.js";
import { FakeLine } from "./fake-connection.js";

let line: FakeLine;
beforeEach(() => {
  vi.useFakeTimers({ toFake: ["setTimeout", "clearTimeout", "setInterval", "clearInterval", "performance"] });
  line = new FakeLine();
});
afterEach(() => {
  vi.useRealTimers();
});
const siteNews = (site: string, online: boolean): ToBrowser => ({ t: "site", site, online, since_us: 0, catalogue: "", loop_ms: 0, skew_ms: 0, why: "", rival_us: 0, away: false });
const stopNews = (site: string, id: string, confirmed: boolean): ToBrowser => ({ t: "stop_news", site, device: "base", latched: true, confirmed, who: "ada", time_us: 1, id });

describe("STOP of a group", () => {
  let group: GroupStopClient;
  const targets = ["a", "b", "c"].map((site) => ({ site, device: "base" }));
  beforeEach(() => {
    group = new GroupStopClient(line);
    group.open();
  });
  afterEach(() => {
    group.close();
  });

  test("leaves for all of them before the press returns, with ids that begin alike", () => {
    const id = group.pressStop(targets);
    expect(line.take("stop")).toEqual(targets.map((target, at) => ({ t: "stop", ...target, id: `${id}.${String(at + 1)}` })));
  });

  test("is repeated to each until its own gateway names it; one that is slow holds up nobody", () => {
    const id = group.pressStop(targets);
    line.take("stop");
    line.say(stopNews("b", `${id}.2`, false));
    vi.advanceTimersByTime(250);
    expect(line.take("stop").map((message) => message["site"])).toEqual(["a", "c"]);
    line.say(stopNews("b", `${id}.2`, true));
    expect(group.rows.map(({ phase }) => phase)).toEqual(["sent", "confirmed", "sent"]);
    expect(group.rows[1]).toMatchObject({ who: "ada" });
  });

  test("goes to a site that is known to be away, too, is not repeated there, and again the moment it is back", () => {
    const id = group.pressStop(targets, ["c"]);
    expect(line.take("stop").map((message) => message["site"])).toEqual(["a", "b", "c"]);
    vi.advanceTimersByTime(1000);
    expect(line.take("stop").map((message) => message["site"])).not.toContain("c");
    expect(group.rows[2]).toMatchObject({ online: false, phase: "sent" });
    line.say(siteNews("c", true));
    expect(line.take("stop")).toEqual([{ t: "stop", site: "c", device: "base", id: `${id}.3` }]);
  });

  test("is sent again after the page's own line was lost", () => {
    group.pressStop(targets.slice(0, 1));
    line.take("stop");
    line.become("lost");
    line.become("open");
    vi.advanceTimersByTime(250);
    expect(line.take("stop")).toHaveLength(1);
  });
});

describe("a command to a group", () => {
  let group: GroupCommandClient;
  const asked = { device: "base", command: "wander", args: { active: true }, units: {} };
  const news = (site: string, id: string, phase: "running" | "succeeded" | "refused"): ToBrowser =>
    ({ t: "command_news", site, device: "base", command: "wander", id, phase, message: "", progress: 0, who: "", blocked_by: "", acting: "", acting_s: 0 });
  const phases = (): readonly string[] => group.rows.map(({ phase }) => phase);
  beforeEach(() => {
    group = new GroupCommandClient(line);
    group.open();
  });
  afterEach(() => {
    group.close();
  });

  test("goes to each once, and each tells by itself what became of it", () => {
    const id = group.sendCommand(["a", "b"], asked);
    expect(line.take("command")).toEqual(["a", "b"].map((site, at) => ({ t: "command", site, ...asked, id: `${id}.${String(at + 1)}`, over: "" })));
    line.say(news("b", `${id}.2`, "succeeded"));
    expect(phases()).toEqual(["sent", "succeeded"]);
    line.say(news("a", `${id}.1`, "refused"));
    expect(phases()).toEqual(["refused", "succeeded"]);
  });

  test("is unknown where the link was lost, and is sent to nobody again", () => {
    const id = group.sendCommand(["a", "b"], asked);
    line.take("command");
    line.say(news("a", `${id}.1`, "running"));
    line.say(siteNews("a", false));
    expect(phases()).toEqual(["unknown", "sent"]);
    line.say(siteNews("a", true));
    vi.advanceTimersByTime(10_000);
    expect(line.take("command")).toEqual([]);
    expect(phases()).toEqual(["unknown", "unknown"]);
  });

  test("can be cancelled where it is under way", () => {
    const id = group.sendCommand(["a", "b"], asked);
    line.say(news("a", `${id}.1`, "succeeded"));
    line.say(news("b", `${id}.2`, "running"));
    line.take("command");
    group.cancelRunning();
    expect(line.take("cancel")).toEqual([{ t: "cancel", site: "b", device: "base", id: `${id}.2` }]);
  });

  test("without a connection is offline at once for all", () => {
    line.become("lost");
    group.sendCommand(["a", "b"], asked);
    expect(phases()).toEqual(["offline", "offline"]);
  });
});
