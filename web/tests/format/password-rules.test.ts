import { describe, expect, test } from "vitest";
import { passwordProblem, passwordRules } from "../../src/format/password-rules.js";

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
