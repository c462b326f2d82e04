import { describe, expect, it } from "vitest";
import { lengthOf, notAfter, pinched, SHORTEST_US, zoomed } from "../../src/series/time-window.js";
import { forSeeds } from "./seeded.js";

describe("a window", () => {
  it("keeps the moment under the pointer where it is when it zooms", () => {
    forSeeds(100, (roll) => {
      const span = { fromUs: 1.7e15, toUs: 1.7e15 + 1e6 + roll() * 1e12 };
      const about = span.fromUs + roll() * lengthOf(span);
      const next = zoomed(span, 0.2 + roll() * 4, about);
      const part = (of: typeof span): number => (about - of.fromUs) / lengthOf(of);
      expect(part(next)).toBeCloseTo(part(span), 4);
    });
  });

  it("does not get shorter than a few samples, nor end in the future", () => {
    expect(lengthOf(zoomed({ fromUs: 0, toUs: 20_000 }, 1e-6, 5))).toBe(SHORTEST_US);
    expect(notAfter({ fromUs: 50, toUs: 150 }, 100)).toEqual({ fromUs: 0, toUs: 100 });
    expect(notAfter({ fromUs: 0, toUs: 90 }, 100)).toEqual({ fromUs: 0, toUs: 90 });
  });

  it("puts two pinched moments under the two fingers", () => {
    const span = pinched(1e6, 2e6, 0.25, 0.75);
    expect(span).toEqual({ fromUs: 0.5e6, toUs: 2.5e6 });
    expect(pinched(1e6, 2e6, 0.5, 0.5)).toBeNull();
    expect(pinched(2e6, 1e6, 0.2, 0.8)).toBeNull();
  });
});
