import { expect, test } from "vitest";
import { formatMoment, parseMoment } from "../../src/format/julian-date.js";

test.each([
  ["JD 2440587.5", 0],
  ["2451545.0", Date.UTC(2000, 0, 1, 12) * 1000],
  ["BJD 2451545", Date.UTC(2000, 0, 1, 12) * 1000],
  ["MJD 51544.5", Date.UTC(2000, 0, 1, 12) * 1000],
  ["2026-12-04", Date.UTC(2026, 11, 4) * 1000],
  ["2026-12-04 21:30", Date.UTC(2026, 11, 4, 21, 30) * 1000],
  ["2026-12-04T21:30:15.5Z", Date.UTC(2026, 11, 4, 21, 30, 15, 500) * 1000],
  ["2415020,5", Date.UTC(1900, 0, 1) * 1000],
])("%s is a moment", (text, us) => {
  expect(parseMoment(text)).toBe(us);
});

test.each(["", "soon", "51544.5", "2026-13-04", "JD 12"])("%j is none", (text) => {
  expect(parseMoment(text)).toBeNaN();
});

test("a moment that is written is read again within a millisecond", () => {
  for (const us of [0, 1_796_342_400_123_000, Date.UTC(2023, 1, 24, 14, 57, 41) * 1000, 951_696_000_000_000]) {
    expect(Math.abs(parseMoment(formatMoment(us)) - us)).toBeLessThan(1000);
  }
  expect(formatMoment(Date.UTC(2000, 0, 1, 12) * 1000)).toBe("JD 2451545");
});
