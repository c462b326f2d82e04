import { beforeEach, expect, test } from "vitest";
import { ANSWER_MS, LeaseMachine, RENEW_MS, type LeaseReport } from "../../../src/controllers/drive/lease-machine.js";

function word(more: Partial<LeaseReport> = {}): LeaseReport {
  return {
    holder: "", yours: false, epoch: 0, remains_ms: 0, rival: "", asking: false, answer_ms: 0, refused: "",
    forceable: false, ...more,
  };
}
const MINE = word({ holder: "Ada", yours: true, epoch: 3, remains_ms: 3000 });

let desk: LeaseMachine;
beforeEach(() => {
  desk = new LeaseMachine();
});

test("taking asks once, and the answer makes it mine", () => {
  expect(desk.requestLease(0)).toBe("take");
  expect(desk.requestLease(10)).toBeNull();
  expect(desk.applyUpdate(MINE, 20)).toBeNull();
  expect(desk.state).toEqual({ kind: "mine", epoch: 3, until: 3020, rival: null });
  expect(desk.epoch).toBe(3);
});

test("it is renewed once a second", () => {
  desk.requestLease(0);
  desk.applyUpdate(MINE, 0);
  expect(desk.advance(RENEW_MS - 1).ask).toBeNull();
  expect(desk.advance(RENEW_MS).ask).toBe("renew");
  expect(desk.advance(RENEW_MS + 1).ask).toBeNull();
  desk.applyUpdate(MINE, RENEW_MS + 5);
  expect(desk.advance(2 * RENEW_MS).ask).toBe("renew");
});

test("a renewal without an answer loses it when its time is out", () => {
  desk.requestLease(0);
  desk.applyUpdate(MINE, 0);
  expect(desk.advance(2999).ended).toBeNull();
  expect(desk.advance(3000).ended).toBe("lease lost");
  expect(desk.epoch).toBe(0);
  expect(desk.trouble).toContain("ran out");
});

test("who has it after my time was out is told, also when the gateway's word comes late", () => {
  desk.requestLease(0);
  desk.applyUpdate(word({ yours: true, epoch: 7, remains_ms: 3000, rival: "Grace", answer_ms: 5000 }), 0);
  expect(desk.answerRequest(true)).toBe("accept");
  desk.advance(3000);
  desk.applyUpdate(word({ holder: "Grace", remains_ms: 2000 }), 3500);
  expect(desk.trouble).toBe("You handed control to Grace.");
  // Who had nothing is told nothing.
  const onlooker = new LeaseMachine();
  onlooker.applyUpdate(word({ holder: "Grace", remains_ms: 2000 }), 3500);
  expect(onlooker.trouble).toBe("");
});

test("somebody else who has it is named, and a refusal says why", () => {
  desk.requestLease(0);
  desk.applyUpdate(word({ holder: "Grace", remains_ms: 2000, refused: "Grace is driving." }), 5);
  expect(desk.state).toEqual({ kind: "other", holder: "Grace", forceable: false });
  expect(desk.trouble).toBe("Grace is driving.");
});

test("being taken over while holding says by whom", () => {
  desk.requestLease(0);
  desk.applyUpdate(MINE, 0);
  expect(desk.applyUpdate(word({ holder: "Grace", remains_ms: 3000 }), 50)).toBe("lease lost");
  expect(desk.trouble).toBe("Grace has control now.");
});

test("a lease that ends without a new holder says so too", () => {
  desk.requestLease(0);
  desk.applyUpdate(MINE, 0);
  expect(desk.applyUpdate(word(), 50)).toBe("lease lost");
  expect(desk.state).toEqual({ kind: "free" });
  expect(desk.trouble).not.toBe("");
});

test("a late answer to a renewal does not bring back what I let go", () => {
  desk.requestLease(0);
  desk.applyUpdate(MINE, 0);
  expect(desk.releaseLease()).toBe("free");
  expect(desk.applyUpdate(MINE, 10)).toBeNull();
  expect(desk.epoch).toBe(0);
});

test("a lease nobody here asked for is not mine", () => {
  desk.applyUpdate(MINE, 0);
  expect(desk.epoch).toBe(0);
});

test("news of the old state does not answer the ask that is under way", () => {
  desk.requestLease(0);
  desk.applyUpdate(word(), 5);
  expect(desk.state.kind).toBe("asking");
});

test("no answer in time: it is let go, and may be tried again", () => {
  desk.requestLease(0);
  expect(desk.advance(ANSWER_MS - 1).ask).toBeNull();
  expect(desk.advance(ANSWER_MS)).toEqual({ ask: "free", ended: null });
  expect(desk.trouble).toContain("did not answer");
  expect(desk.requestLease(ANSWER_MS + 1)).toBe("take");
});

test("a lost link ends it without asking, and says so only to a holder", () => {
  desk.onLinkLost("The link is gone.");
  expect(desk.trouble).toBe("");
  desk.requestLease(0);
  desk.applyUpdate(MINE, 0);
  desk.onLinkLost("The link is gone.");
  expect(desk.state).toEqual({ kind: "unknown" });
  expect(desk.trouble).toBe("The link is gone.");
  expect(desk.advance(10_000)).toEqual({ ask: null, ended: null });
});

test("freeing what is not mine asks nothing", () => {
  expect(desk.releaseLease()).toBeNull();
});

const THEIRS = word({ holder: "Grace", remains_ms: 3000 });
const WAITING = word({ holder: "Grace", rival: "Ada", asking: true, answer_ms: 5000 });
const DENIED = word({ holder: "Grace", refused: "Grace keeps control", forceable: true });

test("somebody else who has it is asked, and the time to answer is counted down", () => {
  desk.applyUpdate(THEIRS, 0);
  expect(desk.requestLease(0)).toBe("ask");
  desk.applyUpdate(WAITING, 10);
  expect(desk.state).toEqual({ kind: "waiting", holder: "Grace", until: 5010 });
  expect(desk.answerRemainingMs(2010)).toBe(3000);
  expect(desk.applyUpdate({ ...MINE, epoch: 4 }, 3000)).toBeNull();
  expect(desk.epoch).toBe(4);
});

test.each([
  ["said to me first", [DENIED, THEIRS]],
  ["said to all first", [THEIRS, DENIED]],
])("a no is told and may be forced, %s", (_, words) => {
  desk.applyUpdate(THEIRS, 0);
  desk.requestLease(0);
  desk.applyUpdate(WAITING, 0);
  for (const update of words) desk.applyUpdate(update, 100);
  expect(desk.trouble).toBe("Grace keeps control");
  expect(desk.state).toEqual({ kind: "other", holder: "Grace", forceable: true });
  expect(desk.forceTakeover(200)).toBe("force");
});

test("nothing can be forced that was not asked in vain", () => {
  desk.applyUpdate(THEIRS, 0);
  expect(desk.forceTakeover(0)).toBeNull();
});

test("an ask for mine is answered once, and handing over says to whom", () => {
  desk.requestLease(0);
  desk.applyUpdate(MINE, 0);
  expect(desk.answerRequest(true)).toBeNull();
  desk.applyUpdate({ ...MINE, rival: "Grace", answer_ms: 5000 }, 10);
  expect(desk.answerRemainingMs(1010)).toBe(4000);
  expect(desk.answerRequest(true)).toBe("accept");
  expect(desk.answerRequest(true)).toBeNull();
  expect(desk.applyUpdate(THEIRS, 60)).toBe("lease lost");
  desk.applyUpdate({ ...THEIRS, refused: "Grace is driving" }, 70);
  expect(desk.trouble).toBe("You handed control to Grace.");
});

test("an ask that is withdrawn is not shown any more, and one that is denied is not either", () => {
  desk.requestLease(0);
  desk.applyUpdate(MINE, 0);
  desk.applyUpdate({ ...MINE, rival: "Grace", answer_ms: 5000 }, 10);
  desk.applyUpdate(MINE, 20);
  expect(desk.answerRequest(false)).toBeNull();
  desk.applyUpdate({ ...MINE, rival: "Grace", answer_ms: 5000 }, 30);
  expect(desk.answerRequest(false)).toBe("deny");
  expect(desk.answerRemainingMs(40)).toBe(0);
});

test("whoever no longer waits withdraws the ask, and a silent gateway ends the wait", () => {
  desk.applyUpdate(THEIRS, 0);
  desk.requestLease(0);
  desk.applyUpdate(WAITING, 0);
  expect(desk.releaseLease()).toBe("free");
  desk.requestLease(10);
  desk.applyUpdate(WAITING, 10);
  expect(desk.advance(5010).ask).toBeNull();
  expect(desk.advance(5010 + 1500).ask).toBe("free");
  expect(desk.state.kind).toBe("other");
});
