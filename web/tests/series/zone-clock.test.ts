import { describe, expect, it } from "vitest";
import { HOUR_US, momentProblem, ZoneClock } from "../../src/series/zone-clock.js";
import { forSeeds } from "./seeded.js";

const utc = (text: string): number => Date.parse(`${text}Z`) * 1000;
const madrid = new ZoneClock("Europe/Madrid");
describe("a zone's clock", () => {
  it("gives back the moment that it wrote into a field, whatever the zone", () => {
    for (const zone of ["UTC", "Europe/Madrid", "Asia/Kathmandu", "America/St_Johns", "Pacific/Apia"]) {
      const clock = new ZoneClock(zone);
      forSeeds(40, (roll) => {
        const at = Math.floor(utc("2020-01-01T00:00") / 1e6 + roll() * 3e8) * 1e6;
        const again = clock.fromInput(clock.toInput(at));
        // An hour that comes twice in autumn can only mean its first coming.
        expect(again === at || again === at - HOUR_US).toBe(true);
      });
    }
  });

  it("knows where days begin, also those of 23 and 25 hours", () => {
    expect(madrid.dayStart(utc("2026-03-29T12:00"))).toBe(utc("2026-03-28T23:00"));
    expect(madrid.dayAfter(utc("2026-03-29T12:00"), 1)).toBe(utc("2026-03-29T22:00"));
    expect(madrid.dayAfter(utc("2026-10-25T12:00"), 1)).toBe(utc("2026-10-25T23:00"));
    expect(madrid.dayAfter(utc("2026-11-21T12:00"), -1)).toBe(utc("2026-11-19T23:00"));
  });

  it("takes a time that summer time skips for the one an hour later, and nonsense for none", () => {
    expect(madrid.fromInput("2026-03-29T02:30:00")).toBe(utc("2026-03-29T01:30:00"));
    expect(madrid.toInput(utc("2026-03-29T12:05:09"))).toBe("2026-03-29 14:05:09");
    expect(madrid.fromInput(" 2026-03-29 14:05 ")).toBe(utc("2026-03-29T12:05:00"));
    for (const none of ["", "2026-03-29", "29.3.2026 14:05", "2026-03-29 25:00", "2026-13-29 14:05"]) expect(madrid.fromInput(none)).toBeNaN();
    expect([momentProblem(" ", Number.NaN), momentProblem("2026-03-29 14:05", 1)]).toEqual(["", ""]);
    expect(momentProblem("2 PM", Number.NaN)).toContain("2026-03-29 14:05:09");
  });
});
