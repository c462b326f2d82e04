import { describe, expect, test } from "vitest";
import { browserName } from "../../src/format/user-agent.js";
import { passwordRules, passwordProblem } from "../../src/format/password-rules.js";
import { permissionText } from "../../src/format/permissions.js";
import { actionAdvice, isFactor, signInAdvice, waitOf } from "../../src/format/error-advice.js";
import { Refused, Unreachable } from "../../src/wire/hub-api.js";

describe("a new password", () => {
  const trouble = (password: string, again = password): string => passwordProblem(passwordRules(password, "Ada", again));

  test("is taken when it is long enough, not the name, and typed twice", () => {
    expect(trouble("eight888")).toBe("");
    expect(trouble("seven77")).toMatch(/8 characters/);
    expect(trouble("eight888", "eight889")).toMatch(/typed twice/);
    expect(passwordProblem(passwordRules("Margarethe", "margarethe", "Margarethe"))).toMatch(/name/);
  });

  test("may be of any characters, each counted once", () => {
    expect(trouble("🦊🦊🦊🦊🦊🦊🦊")).toMatch(/8 characters/);
    expect(trouble("🦊🦊🦊🦊🦊🦊🦊🦊")).toBe("");
  });

  test("of less than fifteen characters is advised against, not refused", () => {
    const advice = passwordRules("eight888", "", "eight888").filter(({ must }) => !must);
    expect(advice.map(({ kept }) => kept)).toEqual([false]);
  });
});

test.each([
  ["Mozilla/5.0 (X11; Linux x86_64) AppleWebKit/537.36 (KHTML, like Gecko) Chrome/140.0 Safari/537.36", "Chrome on Linux"],
  ["Mozilla/5.0 (Windows NT 10.0) AppleWebKit/537.36 Chrome/140.0 Safari/537.36 Edg/140.0", "Edge on Windows"],
  ["Mozilla/5.0 (iPhone; CPU iPhone OS 18_0 like Mac OS X) AppleWebKit Version/18.0 Safari/604.1", "Safari on iPhone"],
  ["Mozilla/5.0 (X11; Linux x86_64; rv:140.0) Gecko/20100101 Firefox/140.0", "Firefox on Linux"],
  ["python-httpx/0.28", "python-httpx/0.28"],
  ["", "Unknown program"],
])("%s is called %s", (agent, words) => {
  expect(browserName(agent)).toBe(words);
});

test("permissions are told by place", () => {
  expect(permissionText([])).toBe("nothing");
  expect(
    permissionText([
      { right: "view", site: "*", device: "*" },
      { right: "use", site: "agv", device: "base" },
      { right: "use", site: "dome", device: "*" },
    ]),
  ).toBe("view every site, use agv base, use all of dome");
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
