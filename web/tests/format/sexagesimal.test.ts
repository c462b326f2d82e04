import { expect, test } from "vitest";
import { formatAzimuth, formatDec, formatRa, parseDec, parseRa, windOf, writeDec, writeRa } from "../../src/format/sexagesimal.js";

test("right ascension is written in hours, minutes and seconds, and never as sixty", () => {
  expect(formatRa(5.575556)).toBe("05h 34m 32s");
  expect(formatRa(23.99999)).toBe("00h 00m 00s");
  expect(formatRa(Number.NaN)).toBe("–");
});

test("what is written into a field is read as the same place", () => {
  expect([writeRa(23.9999999), writeDec(-0.00001), writeDec(-5.391111)]).toEqual(["00:00:00.00", "+00:00:00.0", "-05:23:28.0"]);
  for (const [ra, dec] of [[0.71235, 41.26908], [17.9634, -0.4], [23.99, -89.98765]] as const) {
    expect(parseRa(writeRa(ra))).toBeCloseTo(ra, 5);
    expect(parseDec(writeDec(dec))).toBeCloseTo(dec, 4);
  }
});

test("declination keeps its sign, also within a degree of zero", () => {
  expect(formatDec(41.26917)).toBe("+41° 16′ 09″");
  expect(formatDec(-0.5)).toBe("−00° 30′ 00″");
  expect(formatDec(-0.00001)).toBe("+00° 00′ 00″");
});

test.each([
  ["5h34m32s", 5.575556], ["05:34:32", 5.575556], ["5 34 32", 5.575556], ["5.575556", 5.575556],
  ["5.575556 h", 5.575556], ["83.63333°", 5.575556], ["83.63333d", 5.575556], ["5h 34m", 5.566667],
  ["5,575556", 5.575556], ["0", 0],
])("%s is understood as right ascension", (text, hours) => {
  expect(parseRa(text)).toBeCloseTo(hours, 5);
});

test.each([
  ["-5 23 28", -5.391111], ["−5:23:28", -5.391111], ["+41°16′09″", 41.269167], ["41d16m09s", 41.269167],
  ["-0:30", -0.5], ["-5.39", -5.39], ["41.27°", 41.27], ["41°16'09''", 41.269167],
])("%s is understood as declination", (text, degrees) => {
  expect(parseDec(text)).toBeCloseTo(degrees, 5);
});

test.each(["", "M31", "25", "5:61", "-3", "1e3", "5h34m72s"])("%s is no right ascension", (text) => {
  expect(parseRa(text)).toBeNaN();
});

test.each(["", "north", "91", "-90.1", "5:61"])("%s is no declination", (text) => {
  expect(parseDec(text)).toBeNaN();
});

test("an azimuth says its wind", () => {
  expect(formatAzimuth(275.21)).toBe("275.2° W");
  expect([0, 44, 91, 181, 359].map(windOf)).toEqual(["N", "NE", "E", "S", "N"]);
});
