import { describe, expect, test } from "vitest";
import { flatPosition, headingOfYaw, placeOfFlat, placeOfLocal, wayBetween, type MapPlace } from "../../../src/elements/map/geodesy.js";
import geodesic from "geographiclib-geodesic";

const { WGS84 } = geodesic.Geodesic;

/** Always the same places: a test that fails once fails again. */
function* places(count: number): Generator<MapPlace & { readonly azimuth: number; readonly metres: number }> {
  let seed = 20_26;
  const next = (): number => {
    seed = (Math.imul(seed, 1_664_525) + 1_013_904_223) >>> 0;
    return seed / 2 ** 32;
  };
  for (let i = 0; i < count; i++) yield { lat: (next() - 0.5) * 178, lon: (next() - 0.5) * 360, azimuth: next() * 360, metres: 10 ** (next() * 4 - 1) };
}

describe("the plane that touches the ellipsoid", () => {
  test("has the geodesic's distance to a centimetre and its direction to a thousandth of a degree within a kilometre, anywhere", () => {
    for (const { lat, lon, azimuth, metres } of places(2000)) {
      const { lat2 = 0, lon2 = 0 } = WGS84.Direct(lat, lon, azimuth, metres);
      const way = wayBetween({ lat, lon }, { lat: lat2, lon: lon2 });
      expect(Math.abs(way.metres - metres)).toBeLessThan(0.01);
      // Across the way, in metres: near the poles an angle alone says little.
      const aside = metres * Math.sin(((way.heading - azimuth) * Math.PI) / 180);
      expect(Math.abs(aside)).toBeLessThan(0.01);
    }
  });

  test("leads back to the place it came from, to a tenth of a millimetre", () => {
    for (const { lat, lon, azimuth, metres } of places(2000)) {
      const flat = { x: metres * Math.sin(azimuth), y: metres * Math.cos(azimuth) };
      const back = flatPosition(placeOfFlat(flat, { lat, lon }), { lat, lon });
      // What lies off the plane is put down on the ellipsoid below it: micrometres at a kilometre, in the plane.
      expect(Math.hypot(back.x - flat.x, back.y - flat.y)).toBeLessThan(metres < 1000 ? 1e-4 : 2e-1);
    }
  });

  test("takes the short way over the antimeridian", () => {
    expect(wayBetween({ lat: 10, lon: 179.9999 }, { lat: 10, lon: -179.9999 })).toMatchObject({ heading: expect.closeTo(90, 3) as unknown });
  });
});

describe("a local frame", () => {
  const origin = { lat: 41.387, lon: 2.168 };

  test("whose x points east is the plane itself", () => {
    const flat = flatPosition(placeOfLocal({ x: 30, y: 40 }, { ...origin, heading: 90 }), origin);
    expect(flat.x).toBeCloseTo(30, 5);
    expect(flat.y).toBeCloseTo(40, 5);
  });

  test("that is turned has its x where the heading says, and its y to the left of it", () => {
    const north = flatPosition(placeOfLocal({ x: 10, y: 0 }, { ...origin, heading: 0 }), origin);
    expect([north.x, north.y].map((part) => Math.round(part * 1e4) / 1e4 + 0)).toEqual([0, 10]);
    const west = flatPosition(placeOfLocal({ x: 0, y: 10 }, { ...origin, heading: 0 }), origin);
    expect([west.x, west.y].map((part) => Math.round(part * 1e4) / 1e4 + 0)).toEqual([-10, 0]);
  });

  test("turns a yaw into a heading from north", () => {
    expect(headingOfYaw(0, 90)).toBeCloseTo(90);
    expect(headingOfYaw(Math.PI / 2, 90)).toBeCloseTo(0);
    expect(headingOfYaw(Math.PI, 0)).toBeCloseTo(180);
    expect(headingOfYaw(Number.NaN, 90)).toBeNaN();
  });
});
