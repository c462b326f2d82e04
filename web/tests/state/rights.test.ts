import { describe, expect, test } from "vitest";
import {
  ANY,
  EVERYWHERE,
  givesExtra,
  inheritedLevel,
  inheritsExtra,
  levelAt,
  mayUse,
  ownLevel,
  samePermissions,
  seesOnlyPublic,
  withLevel,
} from "../../src/state/rights.js";
import type { PermissionShape } from "../../src/generated/api.js";

const give = (right: PermissionShape["right"], site: string, device = ANY): PermissionShape => ({ right, site, device });
const agv = { site: "agv", device: ANY };
const base = { site: "agv", device: "base" };

describe("a level", () => {
  test("is the highest of what the place and wider places give", () => {
    const given = [give("view", ANY), give("use", "agv"), give("view", "agv", "base")];
    expect(levelAt(given, base)).toBe("use");
    expect(levelAt(given, { site: "dome", device: "roof" })).toBe("view");
    expect(levelAt([], base)).toBe("none");
  });

  test("of a device says nothing of its site, nor of another device", () => {
    const given = [give("admin", "agv", "base")];
    expect(levelAt(given, agv)).toBe("none");
    expect(levelAt(given, { site: "agv", device: "arm" })).toBe("none");
  });

  test("of one device at every site is inherited by that device only", () => {
    const given = [give("use", ANY, "base")];
    expect(inheritedLevel(given, base)).toBe("use");
    expect(inheritedLevel(given, agv)).toBe("none");
  });

  test("of its own leaves wider places aside", () => {
    const given = [give("use", "agv"), give("view", "agv", "base")];
    expect(ownLevel(given, base)).toBe("view");
    expect(inheritedLevel(given, base)).toBe("use");
    expect(inheritedLevel(given, EVERYWHERE)).toBe("none");
  });
});

describe("raw topics", () => {
  test("stand beside all levels, and come with admin or from a wider place", () => {
    const given = [give("tap", "agv"), give("view", "agv", "base"), give("admin", "dome")];
    expect(levelAt(given, agv)).toBe("none");
    expect([givesExtra(given, agv, "tap"), inheritsExtra(given, agv, "tap")]).toEqual([true, false]);
    expect([givesExtra(given, base, "tap"), inheritsExtra(given, base, "tap")]).toEqual([false, true]);
    expect(inheritsExtra(given, { site: "dome", device: "roof" }, "tap")).toBe(true);
    expect(samePermissions(given, given.slice(1))).toBe(false);
  });
});

describe("giving a level", () => {
  test("takes the place of what was given there before, and touches no other place", () => {
    const given = [give("view", "agv", "base"), give("use", "agv", "base"), give("view", "dome")];
    expect(withLevel(given, base, "admin")).toEqual([give("view", "dome"), give("admin", "agv", "base")]);
    expect(withLevel(given, base, "none")).toEqual([give("view", "dome")]);
  });

  test("and taking it back is no change", () => {
    const given = [give("view", "agv"), give("use", "dome")];
    const there = withLevel(given, agv, "admin");
    expect(samePermissions(there, given)).toBe(false);
    expect(samePermissions(withLevel(there, agv, "view"), given)).toBe(true);
  });
});

test("who holds no right sees only what is public", () => {
  expect(seesOnlyPublic({ admin: false, permissions: [] })).toBe(true);
  expect(seesOnlyPublic({ admin: false, permissions: [give("view", "agv", "base")] })).toBe(false);
  expect(seesOnlyPublic({ admin: true, permissions: [] })).toBe(false);
});

test("an alarm about more than one device is used by whoever may use the whole site", () => {
  const person = { permissions: [{ right: "use", site: "agv", device: "base" }, { right: "view", site: "agv", device: ANY }] satisfies PermissionShape[] };
  expect([mayUse(person, "agv", "base"), mayUse(person, "agv", ""), mayUse(person, "dome", "base"), mayUse(null, "agv", "base")]).toEqual([true, false, false, false]);
  expect(mayUse({ permissions: [{ right: "admin", site: ANY, device: ANY }] }, "agv", "")).toBe(true);
});
