import { expect, test } from "vitest";
import { curveNight } from "../../../src/pages/requests/outlook-curve.js";

const STEP_US = 600e6;
const times_us = [0, 1, 2, 3, 4, 5].map((i) => i * STEP_US);
const CURVE = { times_us, altitude: [10, 40, 30, 20, 50, 60], sun_altitude: [-20, -20, -20, -20, -20, -5], moon_altitude: [1, 2, 3, 4, 5, 6], allowed: [false, true, true, false, true, true] };

test("the hub's night is drawn with the stretches in which all constraints hold, and the best of them", () => {
  const drawn = curveNight(CURVE);
  expect(drawn?.allowed).toEqual([{ from: 600e3, to: 1800e3 }, { from: 2400e3, to: 3000e3 }]);
  expect(drawn?.seen).toMatchObject({ seen: true, best: 60, bestMs: 3000e3, highest: 60, lowest: 10, fromMs: 600e3, toMs: 3000e3 });
  expect(drawn?.night.bands.map(({ id }) => id)).toEqual(["night", "civil"]);
});

test("a night in which nothing may be observed has no best moment, and one of a single moment is not drawn", () => {
  const drawn = curveNight({ ...CURVE, allowed: CURVE.allowed.map(() => false) });
  expect(drawn?.allowed).toEqual([]);
  expect([drawn?.seen.seen, drawn?.seen.best]).toEqual([false, Number.NaN]);
  expect(curveNight({ times_us: [0], altitude: [1], sun_altitude: [1], moon_altitude: [1], allowed: [true] })).toBeNull();
});
