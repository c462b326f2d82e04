import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import { CommandClient } from "../../../src/controllers/drive/command-client.js";
import { FakeLine } from "./fake-connection.js";

const AT = { site: "agv", device: "base" } as const;
let line: FakeLine;
beforeEach(() => {
  vi.useFakeTimers({ toFake: ["setTimeout", "clearTimeout", "setInterval", "clearInterval", "performance"] });
  line = new FakeLine();
});
afterEach(() => {
  vi.useRealTimers();
});
describe("a command", () => {
  let commands: CommandClient;
  beforeEach(() => {
    commands = new CommandClient(line, "agv");
    commands.open();
  });
  afterEach(() => {
    commands.close();
  });

  test("is sent once and never again by itself, whatever happens to the link", () => {
    commands.sendCommand("base", "wander", { active: true });
    expect(line.take("command")).toMatchObject([{ ...AT, command: "wander", args: { active: true } }]);
    line.become("lost");
    line.become("open");
    vi.advanceTimersByTime(60_000);
    expect(line.take("command")).toEqual([]);
    expect(commands.desk.latestRequest("base", "wander")?.phase).toBe("unknown");
  });

  test("has another id each time", () => {
    commands.sendCommand("base", "wander", {});
    commands.sendCommand("base", "wander", {});
    const ids = line.take("command").map((message) => message["id"]);
    expect(new Set(ids).size).toBe(2);
  });

  test("without a connection is offline at once, and not kept for later", () => {
    line.become("lost");
    commands.sendCommand("base", "wander", {});
    expect(commands.desk.latestRequest("base", "wander")?.phase).toBe("offline");
    line.become("open");
    expect(line.take("command")).toEqual([]);
  });
});
