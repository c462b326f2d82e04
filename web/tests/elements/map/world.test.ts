import { expect, test } from "vitest";
import { readOutline, worldOutline } from "../../../src/elements/map/world.js";
import { chosenGround, groundChoices } from "../../../src/elements/map/map-offer.js";
import { shareColour } from "../../../src/elements/map/geo-painter.js";

test("an outline is read as its first place and the steps from there", () => {
  expect(readOutline("-10 200 5 -5;0 0 1 1").map((line) => [...line])).toEqual([[-1, 20, -0.5, 19.5], [0, 0, 0.1, 0.1]]);
});

test("the coarse world has all continents, closed, and within the Earth", () => {
  const { land, borders } = worldOutline();
  expect(land.length).toBeGreaterThan(100);
  expect(borders.length).toBeGreaterThan(200);
  for (const ring of land) {
    expect([ring[0], ring[1]]).toEqual([ring.at(-2), ring.at(-1)]);
    for (let i = 0; i < ring.length; i += 2) expect(Math.abs(ring[i] ?? 999) <= 180 && Math.abs(ring[i + 1] ?? 999) <= 90).toBe(true);
  }
  const onLand = (lon: number, lat: number): boolean => land.filter((ring) => isInside(ring, lon, lat)).length % 2 === 1;
  expect([onLand(2, 42), onLand(-100, 40), onLand(135, -25), onLand(20, 0)]).toEqual([true, true, true, true]);
  expect([onLand(-30, 30), onLand(-150, 0)]).toEqual([false, false]);
});

function isInside(ring: Float64Array, lon: number, lat: number): boolean {
  let inside = false;
  for (let i = 0, j = ring.length - 2; i < ring.length; j = i, i += 2) {
    const [x, y, x2, y2] = [ring[i] ?? 0, ring[i + 1] ?? 0, ring[j] ?? 0, ring[j + 1] ?? 0];
    if (y > lat !== y2 > lat && lon < ((x2 - x) * (lat - y)) / (y2 - y) + x) inside = !inside;
  }
  return inside;
}

test("a file of one's own is taken first, and a server that others run is never taken unasked", () => {
  const source = { id: "1", name: "Streets", kind: "tiles", host: "tiles.example", tiles: "", attribution: "", most_zoom: 19 } as const;
  const both = groundChoices({ files: [{ name: "yard", url: "/f" }], sources: [source] });
  expect(chosenGround(both, "").key).toBe("file yard");
  expect(chosenGround(groundChoices({ files: [], sources: [source] }), "").key).toBe("world");
  expect(chosenGround(both, "source 1").host).toBe("tiles.example");
  expect(chosenGround(both, "source 9").key).toBe("file yard");
  expect(groundChoices(null)).toHaveLength(1);
});

test("the ends of a scale differ in hue and brightness", () => {
  expect(shareColour(0)).toBe("hsl(220 95% 38%)");
  expect(shareColour(1)).toBe("hsl(25 95% 62%)");
  expect(shareColour(2)).toBe(shareColour(1));
});
