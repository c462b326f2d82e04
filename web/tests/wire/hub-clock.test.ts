import { expect, test } from "vitest";
import { HubClock } from "../../src/wire/hub-clock.js";

test("no age is told before the first exchange", () => {
  expect(new HubClock().ageMs(5_000_000, 100)).toBeNaN();
});

test("the age of a moment is told by the hub's clock, whatever the page's own says", () => {
  const clock = new HubClock();
  clock.recordExchange(1000, 1010, 500_000_000);
  expect(clock.ageMs(500_000_000, 1005)).toBeCloseTo(0);
  expect(clock.ageMs(499_900_000, 1105)).toBeCloseTo(200);
});

test("the exchange with the shortest round trip is believed", () => {
  const clock = new HubClock();
  clock.recordExchange(0, 2, 1_000_000);
  // This answer was slow on its way back, so its middle is wrong by 200 ms.
  clock.recordExchange(1000, 1400, 2_001_000);
  expect(clock.ageMs(1_999_000, 1001)).toBeCloseTo(1);
  expect(clock.roundTripMs).toBe(400);
});

test("an old exchange is forgotten after thirty newer ones", () => {
  const clock = new HubClock();
  clock.recordExchange(0, 1, 0);
  for (let i = 1; i <= 30; i++) clock.recordExchange(i * 1000, i * 1000 + 10, i * 1_000_000 + 505_000);
  expect(clock.ageMs(30_000_000 + 505_000, 30_005)).toBeCloseTo(0);
});

test("an answer from before its question is not believed", () => {
  const clock = new HubClock();
  clock.recordExchange(100, 90, 0);
  expect(clock.roundTripMs).toBeNaN();
});
