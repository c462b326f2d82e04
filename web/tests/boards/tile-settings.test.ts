import { describe, expect, it } from "vitest";
import { nextInCycle, readBoardQuery, writeBoardQuery } from "../../src/boards/board-query.js";
import { linksOf, settingList, withSetting } from "../../src/boards/tile-settings.js";

describe("settings of tiles", () => {
  it("lead to pages of the web and of the dashboard, and run nothing", () => {
    const lines = ["Manual | https://example.org/a", "/alarms", "Bad | javascript:alert(1)", "Worse | //evil.test", "data:text/html,x", "words alone"];
    expect(linksOf(lines)).toEqual([
      { label: "Manual", href: "https://example.org/a" },
      { label: "/alarms", href: "/alarms" },
    ]);
  });

  it("are left out where they say nothing", () => {
    expect(withSetting({ a: "x", b: 1 }, "a", "")).toEqual({ b: 1 });
    expect(withSetting({}, "signals", [])).toEqual({});
    expect(settingList({ signals: "base/speed" }, "signals")).toEqual(["base/speed"]);
  });
});

describe("the address of a board", () => {
  it("keeps what it is looked at with, and the boards that follow one another", () => {
    const query = { site: "yard", device: "rover2", kiosk: true, cycle: ["a", "b:c"], seconds: 12 };
    expect(readBoardQuery(`?${writeBoardQuery(query)}`)).toMatchObject(query);
    expect(writeBoardQuery({})).toBe("");
    expect(readBoardQuery("?seconds=0.001").seconds).toBe(5);
  });

  it("goes round", () => {
    expect(nextInCycle("b", ["a", "b"])).toBe("a");
    expect(nextInCycle("gone", ["a", "b"])).toBe("a");
    expect(nextInCycle("a", ["a"])).toBe("");
  });
});
