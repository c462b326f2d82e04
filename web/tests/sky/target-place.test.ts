import { describe, expect, it } from "vitest";
import { targetPlace, targetText } from "../../src/sky/target-place.js";

const ICRS = { type: "ICRS", ra: 269.452, dec: 4.693 } as const;
/** Barnard's star, of the Hipparcos catalogue (mas a year). */
const MOTION = { proper_motion_ra: -798.58, proper_motion_dec: 10_328.12 } as const;

describe("a target's place", () => {
  it("moves by its own motion from its epoch", () => {
    const ms = Date.UTC(2050, 0, 1, 12);
    const still = targetPlace(ICRS);
    const moving = targetPlace({ ...ICRS, ...MOTION });
    if (still === null || moving === null || !("at" in still) || !("at" in moving)) throw new Error("no place among the stars");
    // Fifty years of 10.328 arc seconds, to the north.
    expect((moving.at(ms).dec - still.at(ms).dec) * 3600).toBeCloseTo(516.4, 0);
    expect(moving.at(ms).ra).toBeLessThan(still.at(ms).ra);
    const later = targetPlace({ ...ICRS, ...MOTION, epoch: 2050 });
    expect(later !== null && "at" in later && (later.at(ms).dec - still.at(ms).dec) * 3600).toBeCloseTo(0, 1);
  });

  it("is fixed, the Moon's, or none that a page works out", () => {
    expect(targetPlace({ type: "FIXED", altitude: 30, azimuth: 90 })).toEqual({ fixed: { alt: 30, az: 90 } });
    expect(targetPlace({ type: "SOLAR_SYSTEM", body: "moon" })).toHaveProperty("at");
    expect(targetPlace({ type: "SOLAR_SYSTEM", body: "mars" })).toBeNull();
    expect(targetPlace(null)).toBeNull();
  });

  it("is called by its name, else by where it stands", () => {
    expect(targetText({ ...ICRS, name: "M 31" })).toBe("M 31");
    expect(targetText(ICRS)).toBe("17.9635 h 4.693°");
    expect(targetText({ type: "FIXED", altitude: 30, azimuth: 90 })).toBe("altitude 30.0°, azimuth 90.0°");
    expect(targetText({ type: "SOLAR_SYSTEM", body: "mars" })).toBe("Mars");
    expect(targetText(null)).toBe("no target");
  });
});
