import { describe, expect, it } from "vitest";
import { degrees, radians } from "../../src/sky/coordinates.js";
import { fieldCorners, isInField, mosaicOf, type FieldSize, type MosaicPlan } from "../../src/sky/mosaic.js";
import { directionTo, fromPlane, separation, toPlane, type SkyPoint } from "../../src/sky/tangent-plane.js";
import { forSeeds, type Dice } from "../series/seeded.js";

function anyField(roll: Dice): FieldSize {
  const width = 0.1 + roll() * 2;
  return { width, height: width * (0.5 + roll() * 0.6) };
}

function anyPlan(roll: Dice, rotates: boolean): MosaicPlan {
  return { across: 1 + Math.floor(roll() * 4), down: 1 + Math.floor(roll() * 4), overlap: roll() * 0.4, angle: roll() * 360, rotates };
}

function anyCentre(roll: Dice): SkyPoint {
  const way = roll();
  return { raDeg: roll() * 360, decDeg: way < 0.4 ? 90 - roll() * 3 : way < 0.6 ? -90 + roll() * 3 : (roll() - 0.5) * 170 };
}

/** A place on the plane of the mosaic, by its own axes: half of its width to the right is 1. */
function placeIn(centre: SkyPoint, { width, height }: FieldSize, angle: number, right: number, up: number): SkyPoint {
  const [x, y] = [right * degrees(Math.tan(radians(width) / 2)), up * degrees(Math.tan(radians(height) / 2))];
  const [c, s] = [Math.cos(radians(angle)), Math.sin(radians(angle))];
  return fromPlane({ east: y * s - x * c, north: y * c + x * s }, centre);
}

describe("a picture", () => {
  it("is as wide and as high as its field", () => {
    const [a, b, c, d] = fieldCorners({ raDeg: 30, decDeg: 0 }, { width: 2, height: 1 }, 0);
    if (a === undefined || b === undefined || c === undefined || d === undefined) throw new Error("four corners");
    // With north up east is to the left.
    expect(a.raDeg).toBeGreaterThan(b.raDeg);
    expect(a.decDeg).toBeGreaterThan(d.decDeg);
    expect(separation({ raDeg: a.raDeg, decDeg: 0 }, { raDeg: b.raDeg, decDeg: 0 })).toBeCloseTo(2, 9);
  });

  it("has its top where its angle says", () => {
    forSeeds(50, (roll) => {
      const [centre, angle] = [{ raDeg: roll() * 360, decDeg: (roll() - 0.5) * 178 }, roll() * 360];
      const [a, b] = fieldCorners(centre, { width: 0.02, height: 0.02 }, angle);
      if (a === undefined || b === undefined) throw new Error("corners");
      const at = [toPlane(a, centre), toPlane(b, centre)];
      const middle = fromPlane({ east: ((at[0]?.east ?? 0) + (at[1]?.east ?? 0)) / 2, north: ((at[0]?.north ?? 0) + (at[1]?.north ?? 0)) / 2 }, centre);
      expect(Math.abs(((directionTo(centre, middle) - angle + 540) % 360) - 180)).toBeLessThan(1e-6);
    });
  });
});

describe("a mosaic", () => {
  it.each([true, false])("leaves no gap anywhere, the poles among it (with a rotator: %s)", (rotates) => {
    forSeeds(120, (roll) => {
      const [centre, field, plan] = [anyCentre(roll), anyField(roll), anyPlan(roll, rotates)];
      const mosaic = mosaicOf(centre, field, plan);
      expect(mosaic.panels).toHaveLength(plan.across * plan.down);
      for (let i = 0; i < 60; i += 1) {
        // Its very edge is that of a panel that may be turned by a rounding.
        const point = placeIn(centre, mosaic.size, plan.angle, (2 * roll() - 1) * 0.999, (2 * roll() - 1) * 0.999);
        const shown = mosaic.panels.some((panel) => isInField(point, panel.centre, field, panel.angle));
        if (!shown) throw new Error(`not shown: ${JSON.stringify({ centre, field, plan, point })}`);
      }
    });
  });

  it("overlaps as much as was asked: with a rotator no less, and hardly more where it is small", () => {
    forSeeds(60, (roll) => {
      const [centre, field] = [anyCentre(roll), { width: 0.5, height: 0.4 }];
      const plan = { ...anyPlan(roll, true), across: 3, down: 3 };
      const { panels } = mosaicOf(centre, field, plan);
      const [, top, , left, middle] = panels;
      if (middle === undefined || top === undefined || left === undefined) throw new Error("nine panels");
      const shared = (neighbour: SkyPoint, size: number): number => 1 - separation(middle.centre, neighbour) / size;
      expect(shared(left.centre, field.width)).toBeGreaterThanOrEqual(plan.overlap - 1e-6);
      expect(shared(left.centre, field.width)).toBeLessThan(plan.overlap + 0.001);
      expect(shared(top.centre, field.height)).toBeCloseTo(plan.overlap, 3);
    });
  });

  it("of one panel is the field itself", () => {
    const centre = { raDeg: 83.8, decDeg: -5.4 };
    const { panels, size } = mosaicOf(centre, { width: 0.4, height: 0.3 }, { across: 1, down: 1, overlap: 0.2, angle: 33, rotates: true });
    expect(panels).toHaveLength(1);
    expect(panels[0]?.angle).toBe(33);
    expect(separation(panels[0]?.centre ?? { raDeg: 0, decDeg: 0 }, centre)).toBeLessThan(1e-9);
    expect(size.width).toBeCloseTo(0.4, 9);
    expect(size.height).toBeCloseTo(0.3, 9);
  });

  it("turns each panel with its meridian near the pole, and says how far a fixed camera is off", () => {
    const centre = { raDeg: 0, decDeg: 88 };
    const plan = { across: 3, down: 1, overlap: 0.1, angle: 0 };
    const turning = mosaicOf(centre, { width: 1, height: 0.7 }, { ...plan, rotates: true });
    // East is to the left; further east the pole lies to the west of up.
    const [left, , right] = turning.panels;
    expect(left?.centre.raDeg).toBeGreaterThan(20);
    expect(left?.angle).toBeCloseTo(left?.centre.raDeg ?? 0, 1);
    expect(right?.angle).toBeCloseTo(right?.centre.raDeg ?? 0, 1);
    expect([turning.twist, turning.scale]).toEqual([0, 1]);
    const fixed = mosaicOf(centre, { width: 1, height: 0.7 }, { ...plan, rotates: false });
    expect(fixed.panels.map(({ angle }) => angle)).toEqual([0, 0, 0]);
    expect(fixed.twist).toBeGreaterThan(10);
    expect(fixed.scale).toBeLessThan(0.9);
    const far = mosaicOf({ raDeg: 0, decDeg: 10 }, { width: 1, height: 0.7 }, { ...plan, rotates: false });
    expect(far.scale).toBeGreaterThan(0.99);
  });

  it("numbers its panels row by row from the top left", () => {
    const { panels } = mosaicOf({ raDeg: 100, decDeg: 20 }, { width: 0.2, height: 0.1 }, { across: 2, down: 2, overlap: 0.1, angle: 0, rotates: false });
    expect(panels.map(({ row, column }) => [row, column])).toEqual([[1, 1], [1, 2], [2, 1], [2, 2]]);
    const [a, b, c] = panels.map(({ centre }) => centre);
    expect(a?.raDeg).toBeGreaterThan(b?.raDeg ?? 999);
    expect(a?.decDeg).toBeGreaterThan(c?.decDeg ?? 999);
  });
});
