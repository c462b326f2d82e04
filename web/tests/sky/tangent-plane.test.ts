import { describe, expect, it } from "vitest";
import { radians } from "../../src/sky/coordinates.js";
import { directionTo, fromPlane, separation, toPlane, type SkyPoint } from "../../src/sky/tangent-plane.js";
import { forSeeds, type Dice } from "../series/seeded.js";
import vectors from "./tangent-vectors.json";

/** Even over the sky, and often near its poles. */
export function somewhere(roll: Dice): SkyPoint {
  const raDeg = roll() * 360;
  const way = roll();
  const decDeg = way < 0.3 ? 90 - roll() : way < 0.5 ? roll() - 90 : (Math.asin(2 * roll() - 1) * 180) / Math.PI;
  return { raDeg, decDeg };
}

function vectorOf({ raDeg, decDeg }: SkyPoint): readonly [number, number, number] {
  const [a, d] = [radians(raDeg), radians(decDeg)];
  return [Math.cos(d) * Math.cos(a), Math.cos(d) * Math.sin(a), Math.sin(d)];
}

describe("the tangent plane", () => {
  it.each(vectors)("is astropy's at $ra0 $dec0, $east to the east and $north to the north", ({ ra0, dec0, east, north, ra, dec }) => {
    const centre = { raDeg: ra0, decDeg: dec0 };
    expect(separation(fromPlane({ east, north }, centre), { raDeg: ra, decDeg: dec })).toBeLessThan(1e-8);
    const at = toPlane({ raDeg: ra, decDeg: dec }, centre);
    expect(at?.east).toBeCloseTo(east, 7);
    expect(at?.north).toBeCloseTo(north, 7);
  });

  it("gives the same place there and back, at the poles, too", () => {
    forSeeds(300, (roll) => {
      const centre = somewhere(roll);
      const at = { east: (roll() - 0.5) * 40, north: (roll() - 0.5) * 40 };
      const back = toPlane(fromPlane(at, centre), centre);
      expect(back?.east).toBeCloseTo(at.east, 8);
      expect(back?.north).toBeCloseTo(at.north, 8);
    });
  });

  it("measures angles as the product of unit vectors does", () => {
    forSeeds(300, (roll) => {
      const [one, other] = [somewhere(roll), somewhere(roll)];
      const [a, b] = [vectorOf(one), vectorOf(other)];
      const cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
      expect(Math.cos(radians(separation(one, other)))).toBeCloseTo(cosine, 9);
    });
  });

  it("does not show what stands behind", () => {
    expect(toPlane({ raDeg: 190, decDeg: 0 }, { raDeg: 0, decDeg: 0 })).toBeNull();
    expect(toPlane({ raDeg: 90, decDeg: 0 }, { raDeg: 0, decDeg: 0 })).toBeNull();
  });

  it("counts directions from north through east", () => {
    const at = { raDeg: 10, decDeg: 20 };
    expect(directionTo(at, { raDeg: 10, decDeg: 21 })).toBeCloseTo(0, 9);
    expect(directionTo(at, { raDeg: 10.001, decDeg: 20 })).toBeCloseTo(90, 2);
    expect(directionTo(at, { raDeg: 10, decDeg: 19 })).toBeCloseTo(180, 9);
    expect(directionTo(at, { raDeg: 9.999, decDeg: 20 })).toBeCloseTo(270, 2);
  });
});
