import { describe, expect, test } from "vitest";
import { formatAge, formatDuration, formatMs, formatWholeMs } from "../../src/format/duration.js";
import { decimalsFor, formatNumber } from "../../src/format/number.js";
import { adviceFor, signInAdvice } from "../../src/format/error-advice.js";
import { stateWord } from "../../src/format/state-label.js";
import { knownZone, timeText, utcSpan, zoneName } from "../../src/format/time.js";
import { formatWithUnit, spokenUnit } from "../../src/format/unit.js";
import { Refused, Unreachable } from "../../src/wire/hub-api.js";

describe("numbers", () => {
  test.each([
    [0.1834, 2, "0.18"],
    [-1.5, 1, "−1.5"],
    [-0.0004, 2, "0.00"],
    [Number.NaN, 2, "–"],
    [Number.POSITIVE_INFINITY, 2, "∞"],
    [Number.NEGATIVE_INFINITY, 2, "−∞"],
    [9999, 0, "9999"],
    [1234567.5, 1, "1\u202f234\u202f567.5"],
    [0.1234567, 6, "0.123457"],
    [-2.5e12, 2, "−2.500e+12"],
  ])("%d with %d digits is written %s", (value, decimals, text) => {
    expect(formatNumber(value, decimals)).toBe(text);
  });

  test("the digits are the signal's own, or its unit's, or two", () => {
    expect([decimalsFor("m/s", 4), decimalsFor("rad"), decimalsFor("furlong")]).toEqual([4, 3, 2]);
  });

  test("a unit stands apart by a narrow space, a degree sign does not", () => {
    expect(formatWithUnit(21.46, "°C")).toBe("21.5\u202f°C");
    expect(formatWithUnit(41.3874, "°", 4)).toBe("41.3874°");
    expect(formatWithUnit(3, "", 0)).toBe("3");
  });

  test("a screen reader says a unit by its name", () => {
    expect(spokenUnit("m/s")).toBe("metre per second");
  });
});

describe("durations", () => {
  test.each([
    [0.4, "0 s"],
    [59.9, "59 s"],
    [60, "1 min"],
    [200, "3 min 20 s"],
    [7500, "2 h 5 min"],
    [273_600, "3 d 4 h"],
    [-5, "0 s"],
    [Number.NaN, "–"],
  ])("%d seconds last %s", (seconds, text) => {
    expect(formatDuration(seconds)).toBe(text);
  });

  test.each([
    [1.9, "just now"],
    [12.7, "12 s ago"],
    [185, "3 min ago"],
    [7300, "2 h ago"],
    [200_000, "2 d ago"],
  ])("%d seconds are %s", (seconds, text) => {
    expect(formatAge(seconds)).toBe(text);
  });

  test.each([
    [8.42, "8.4\u202fms"],
    [120.4, "120\u202fms"],
    [1234, "1.2\u202fs"],
  ])("%d milliseconds are %s", (ms, text) => {
    expect(formatMs(ms)).toBe(text);
  });
});

describe("moments", () => {
  const summer = Date.UTC(2026, 6, 1, 12, 5, 9) * 1000;

  test("today's moment has no date, and UTC beside it", () => {
    const text = timeText(summer, "Europe/Madrid", summer);
    expect([text.local, text.utc, text.machine]).toEqual(["14:05:09", "12:05:09 UTC", "2026-07-01T12:05:09.000Z"]);
  });

  test("another day's moment has its date, each side its own", () => {
    const late = Date.UTC(2026, 6, 1, 23, 0, 0) * 1000;
    const text = timeText(late, "Europe/Madrid", summer + 86_400_000_000 * 3);
    expect([text.local, text.utc]).toEqual(["2 Jul 2026, 01:00:00", "1 Jul 2026, 23:00:00 UTC"]);
  });

  test("the zone's name follows summer time", () => {
    const winter = Date.UTC(2026, 0, 1) * 1000;
    expect(zoneName(summer, "Europe/Madrid")).not.toBe(zoneName(winter, "Europe/Madrid"));
  });

  test("a zone that this browser does not know counts as UTC", () => {
    expect(knownZone("Moon/Tycho")).toBe("UTC");
    expect(timeText(summer, "Moon/Tycho", summer).local).toBe("12:05:09");
  });
});

describe("words", () => {
  test("a state has its word, or at least its number", () => {
    expect([stateWord(["off", "on"], 1), stateWord(["off", "on"], 7), stateWord([], Number.NaN)]).toEqual(["on", "state 7", "–"]);
  });

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

describe("beside the site's own", () => {
  const day = Date.UTC(2026, 0, 10, 12) * 1000;

  test("a stretch of time stands in UTC too", () => {
    expect(utcSpan({ fromUs: day, toUs: day + 60e6 }, "Europe/Madrid", day)).toBe("12:00:00 – 12:01:00 UTC");
  });

  test("a site that lives in UTC has nothing beside it", () => {
    expect(utcSpan({ fromUs: day, toUs: day + 60e6 }, "UTC", day)).toBe("");
  });

  test("milliseconds are whole, and never none", () => {
    expect([0.2, 1.4, 8.6, 120, 1200].map(formatWholeMs)).toEqual(["1\u202fms", "1\u202fms", "9\u202fms", "120\u202fms", "1.2\u202fs"]);
  });
});
