import { beforeEach, expect, test } from "vitest";
import { CommandMachine } from "../../../src/controllers/drive/command-machine.js";

let desk: CommandMachine;
beforeEach(() => {
  desk = new CommandMachine();
  desk.addRequest("c1", "base", "wander", 5000, 0);
});
const phase = (): string | undefined => desk.latestRequest("base", "wander")?.phase;

test("an ask goes through its states in the robot's words", () => {
  expect(phase()).toBe("sent");
  desk.applyUpdate({ id: "c1", phase: "accepted", message: "", progress: 0 });
  desk.applyUpdate({ id: "c1", phase: "running", message: "turning", progress: 0.5 });
  expect(desk.latestRequest("base", "wander")).toMatchObject({ phase: "running", message: "turning", progress: 0.5 });
  desk.applyUpdate({ id: "c1", phase: "succeeded", message: "done", progress: 1 });
  expect(phase()).toBe("succeeded");
});

test("nothing comes after an end", () => {
  desk.applyUpdate({ id: "c1", phase: "failed", message: "no", progress: 0 });
  desk.applyUpdate({ id: "c1", phase: "running", message: "", progress: 0.1 });
  expect(phase()).toBe("failed");
});

test("no answer within its time is unknown, and only a late end clears that up", () => {
  expect(desk.advance(5999)).toBe(false);
  expect(desk.advance(6000)).toBe(true);
  expect(phase()).toBe("unknown");
  desk.applyUpdate({ id: "c1", phase: "succeeded", message: "", progress: 1 });
  expect(phase()).toBe("succeeded");
});

test("an accepted one is not given up by the page", () => {
  desk.applyUpdate({ id: "c1", phase: "accepted", message: "", progress: 0 });
  expect(desk.advance(60_000)).toBe(false);
});

test("a lost link makes what is under way unknown and leaves what has ended", () => {
  desk.addRequest("c2", "base", "other", 5000, 0);
  desk.applyUpdate({ id: "c1", phase: "succeeded", message: "", progress: 1 });
  desk.onLinkLost();
  expect(phase()).toBe("succeeded");
  expect(desk.latestRequest("base", "other")?.phase).toBe("unknown");
});

test("not sent is offline, not unknown", () => {
  desk.markUnsent("c1");
  expect(phase()).toBe("offline");
});

test("news of somebody else's ask changes nothing here", () => {
  desk.applyUpdate({ id: "theirs", phase: "failed", message: "", progress: 0 });
  expect(phase()).toBe("sent");
});

test("a problem without an id belongs to the newest ask without an answer", () => {
  desk.addRequest("c2", "base", "other", 5000, 1);
  expect(desk.newestUnanswered()?.id).toBe("c2");
  desk.markRefused("c2", "Not for you.", false);
  expect(desk.latestRequest("base", "other")).toMatchObject({ phase: "refused", message: "Not for you." });
  expect(desk.newestUnanswered()?.id).toBe("c1");
});
