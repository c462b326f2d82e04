import { Refused, Unreachable } from "../../src/wire/hub-api.js";
import { actionAdvice, adviceFor, isFactor, signInAdvice, waitOf } from "../../src/format/error-advice.js";
import { describe, expect, test } from "vitest";

describe("advice", () => {
  test("a wrong password, a brake and a missing hub are told apart", () => {
    expect(signInAdvice(new Refused(401, "wrong", "no")).what).toMatch(/wrong/);
    expect(signInAdvice(new Refused(429, "throttled", "no", 29.2)).how).toMatch(/in 30 s\./);
    expect(signInAdvice(new Unreachable("gone")).what).toMatch(/cannot be reached/);
  });

  test("a refusal says what was refused", () => {
    expect(adviceFor(new Refused(403, "forbidden", "no"), "the dome").what).toBe("You may not see the dome.");
    expect(adviceFor(new Refused(500, "internal", "The disk is full."), "the list").how).toBe("The disk is full.");
  });
});

describe("what went wrong", () => {
  test("while something was done begins with what was not done", () => {
    const told = actionAdvice(new Refused(409, "last_admin", "there must be one admin"), "remove ada");
    expect(told).toEqual({ what: "The hub did not remove ada.", how: "There must be one admin." });
    expect(actionAdvice(new Refused(429, "busy", "wait", 90), "try").how).toContain("in 1 min 30 s");
    expect(actionAdvice(new Unreachable("gone"), "try").what).toMatch(/cannot be reached/);
  });

  test("at sign-in tells a wrong code from a wrong password", () => {
    const code = new Refused(401, "factor", "the code is wrong");
    expect(isFactor(code)).toBe(true);
    expect(isFactor(new Refused(401, "wrong", ""))).toBe(false);
    expect(signInAdvice(code).what).toMatch(/code/);
  });

  test("says how long to wait only where the hub did", () => {
    expect(waitOf(new Refused(429, "busy", "", 12))).toBe(12);
    expect(waitOf(new Refused(401, "wrong", "", 12))).toBe(0);
    expect(waitOf(new Unreachable("gone"))).toBe(0);
  });
});
