import { describe, expect, it } from "vitest";
import type { EventShape, SimilarShape } from "../../../src/generated/api.js";
import { causeQuery, excessOf, knownText, momentOf, repeatable, repeatedComment, sortEvents, verdictText } from "../../../src/pages/cause/cause-words.js";

const SIMILAR: SimilarShape = { began_us: 1, names: ["Speed"], likeness: 1, verdict: "confirmed", comment: "a wheel was blocked", who: "ana" };

function event(kind: string): EventShape {
  return { id: kind, time_us: 1, kind, device: "", who: "", message: "", good: true };
}

describe("a cause", () => {
  it("is looked for at the moment of its address, and at nothing else", () => {
    expect(momentOf(`?${causeQuery(1_795_000_000_000_000)}`)).toBe(1_795_000_000_000_000);
    expect(momentOf("")).toBeNaN();
    expect(momentOf("?at=now")).toBeNaN();
    expect(momentOf("?at=-1")).toBeNaN();
  });

  it("tells what was commanded from what else was written down; anomalies are ranked elsewhere", () => {
    const { commands, others } = sortEvents([event("command accepted"), event("anomaly began"), event("lease granted"), event("alarm raised"), event("stop pressed")]);
    expect(commands.map(({ kind }) => kind)).toEqual(["command accepted", "lease granted", "stop pressed"]);
    expect(others.map(({ kind }) => kind)).toEqual(["alarm raised"]);
  });

  it("says what was said of the last one like it", () => {
    expect(verdictText(SIMILAR)).toBe("ana said that it was real: a wheel was blocked.");
    expect(verdictText({ ...SIMILAR, verdict: "forgiven", comment: "" })).toBe("ana said that it was none.");
    expect(verdictText({ ...SIMILAR, verdict: "" })).toBe("Nobody said what it was.");
  });

  it("can be said to be the same again where somebody said what it was", () => {
    expect(repeatable(SIMILAR)).toBe("confirmed");
    expect(repeatable({ ...SIMILAR, verdict: "known" })).toBeNull();
    expect(repeatable(null)).toBeNull();
    expect(repeatedComment(SIMILAR, "26 November 14:00:05")).toBe("same as 26 November 14:00:05: a wheel was blocked");
    expect(repeatedComment({ ...SIMILAR, comment: "" }, "14:00:05")).toBe("same as 14:00:05");
    // Said again and again it does not grow.
    expect(repeatedComment({ ...SIMILAR, comment: "same as 14:00:05: a wheel was blocked" }, "15:00:00")).toBe("same as 15:00:00: a wheel was blocked");
  });

  it("is known while a state holds, or at all times", () => {
    const known = { key: "k", address: "base/speed", detector: "limits", title: "Speed", state: "base/mode", state_name: "Mode is docked", who: "ana", comment: "", since_us: 1, holds: true };
    expect(knownText(known)).toBe("while Mode is docked (now)");
    expect(knownText({ ...known, holds: false })).toBe("while Mode is docked");
    expect(knownText({ ...known, state: "", state_name: "" })).toBe("at all times");
  });

  it("has bars as long as scores are over what they are told from", () => {
    const one = { address: "a/b", detector: "change", title: "B", at_us: 1, newest: true, shares: [] };
    expect(excessOf({ ...one, score: 0.5, bar: 0.6 })).toBe(0);
    expect(excessOf({ ...one, score: 0.8, bar: 0.6 })).toBeCloseTo(0.5);
    expect(excessOf({ ...one, score: 1, bar: 1 })).toBe(0);
  });
});
