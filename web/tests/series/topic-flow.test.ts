import { expect, test } from "vitest";
import { TopicFlow } from "../../src/series/topic-flow.js";

test("how often a topic comes is told by what the gateway counted, with what was left out", () => {
  const flow = new TopicFlow();
  flow.count({ seq: 10, timeUs: 0, ageMs: 0 }, 0);
  expect(flow.hertz).toBeNull();
  flow.count({ seq: 60, timeUs: 1e6, ageMs: 0 }, 1000);
  expect(flow.hertz).toBe(50);
});

test("a gateway that begins anew is counted anew", () => {
  const flow = new TopicFlow();
  flow.count({ seq: 900, timeUs: 0, ageMs: 0 }, 0);
  flow.count({ seq: 1, timeUs: 5e6, ageMs: 0 }, 5000);
  expect(flow.hertz).toBeNull();
  flow.count({ seq: 3, timeUs: 6e6, ageMs: 0 }, 6000);
  expect(flow.hertz).toBe(2);
});

test("the age is that at the hub and what has passed since", () => {
  const flow = new TopicFlow();
  expect(flow.ageMs(0)).toBeNull();
  flow.count({ seq: 1, timeUs: 0, ageMs: 40_000 }, 1000);
  expect(flow.ageMs(2500)).toBe(41_500);
});

test("a topic is stale after three times the time between its messages, and not before five seconds", () => {
  const often = new TopicFlow();
  expect(often.isStale(1e9)).toBe(false);
  often.count({ seq: 1, timeUs: 0, ageMs: 0 }, 0);
  expect([often.isStale(9900), often.isStale(10_100)]).toEqual([false, true]);
  often.count({ seq: 2, timeUs: 1e5, ageMs: 0 }, 100);
  expect([often.isStale(5000), often.isStale(5200)]).toEqual([false, true]);
  const seldom = new TopicFlow();
  seldom.count({ seq: 1, timeUs: 0, ageMs: 0 }, 0);
  seldom.count({ seq: 2, timeUs: 60e6, ageMs: 0 }, 60_000);
  expect([seldom.isStale(239_000), seldom.isStale(241_000)]).toEqual([false, true]);
});
