import { expect, test } from "vitest";
import { precessedFromJ2000 } from "../../src/sky/coordinates.js";
import {
  airmassOf, bestNight, eveningOf, horizontalOf, nightAround, requestVisibility, requestVisibilityText, vetoAt, type SkyConstraints, type VisibilityQuestion,
} from "../../src/sky/request-visibility.js";
import { sunFrom } from "../../src/sky/sun-and-moon.js";

const MONTSEC = { latitude: 42.0517, longitude: 0.7297 };
const ANY: SkyConstraints = { min_altitude: 30, max_airmass: 10, min_moon_distance: 0, max_moon_illumination: 1, max_sun_altitude: -12 };
const NOW = Date.parse("2026-11-23T20:00:00Z");
const WORDS = {
  clock: (ms: number): string => new Date(ms).toISOString().slice(11, 16),
  date: (ms: number): string => new Date(ms).toISOString().slice(0, 10),
  lasting: (ms: number): string => `${(ms / 3_600_000).toFixed(1)} h`,
};

function question(raHours: number, dec: number, more: Partial<SkyConstraints> = {}, windows: VisibilityQuestion["windows"] = []): VisibilityQuestion {
  return { target: { at: (ms) => precessedFromJ2000({ ra: raHours, dec }, ms) }, place: MONTSEC, constraints: { ...ANY, ...more }, windows };
}

test("Andromeda may be observed in a November night while it is dark and high, and at no other time", () => {
  const asked = question(0.712, 41.27);
  const found = requestVisibility(asked, nightAround(NOW, MONTSEC));
  expect(found.spans).toHaveLength(1);
  const [span] = found.spans;
  for (const ms of [span?.from ?? 0, span?.to ?? 0].flatMap((edge) => [edge - 600_000, edge + 600_000])) {
    const inside = ms > (span?.from ?? 0) && ms < (span?.to ?? 0);
    const allowed = sunFrom(MONTSEC, ms).alt <= -12 && horizontalOf(asked.target, MONTSEC, ms).alt >= 30;
    expect(allowed).toBe(inside);
  }
  expect(found.best).toBeGreaterThan(85);
  expect(requestVisibilityText(found, ANY, null, WORDS)).toContain("It may be observed 17:");
});

test("a target that never rises high enough is told so, with how high it gets and that no night is better", () => {
  const asked = question(6.4, -52.7);
  const found = requestVisibility(asked, nightAround(NOW, MONTSEC));
  expect(found.spans).toEqual([]);
  expect(bestNight(asked, NOW)).toBeNull();
  expect(requestVisibilityText(found, ANY, null, WORDS)).toMatch(/^Never above 30° in the dark of this night: -?\d+° at the most\. No other night/);
});

test("a summer target is sent to a summer night", () => {
  const asked = question(17.0, -5);
  const found = requestVisibility(asked, nightAround(NOW, MONTSEC));
  const better = bestNight(asked, NOW);
  expect(found.spans).toEqual([]);
  expect(WORDS.date(better?.night.from ?? 0)).toMatch(/^2027-0[4-7]/);
  expect(requestVisibilityText(found, ANY, better, WORDS)).toContain("Best on 2027-0");
});

test("the first constraint that does not hold is named", () => {
  const noon = nightAround(NOW, MONTSEC).from;
  expect(vetoAt(question(0.712, 41.27), noon)).toBe("sun");
  expect(vetoAt(question(0.712, 41.27, {}, [{ from: NOW + 1, to: NOW + 2 }]), NOW)).toBe("window");
  expect(vetoAt(question(0.712, 41.27, { max_airmass: 1 }), NOW)).toBe("airmass");
  // The Moon of that evening is full, and stands in the Pleiades.
  expect(vetoAt(question(3.79, 24.1, { min_moon_distance: 40 }), NOW)).toBe("moon_distance");
  expect(vetoAt(question(0.712, 41.27, { max_moon_illumination: 0.5 }), NOW)).toBe("moon_illumination");
  expect(vetoAt(question(0.712, 41.27), NOW)).toBeNull();
});

test("a fixed place above the horizon stands where it stands", () => {
  const asked: VisibilityQuestion = { target: { fixed: { alt: 45, az: 180 } }, place: MONTSEC, constraints: ANY, windows: [] };
  expect(requestVisibility(asked, nightAround(NOW, MONTSEC)).best).toBe(45);
  expect(airmassOf(30)).toBeCloseTo(2);
  expect(airmassOf(-1)).toBe(Number.POSITIVE_INFINITY);
});

test("a night is called by the day of its evening, also after midnight", () => {
  for (const moment of ["2026-11-26T13:00:00Z", "2026-11-26T23:53:00Z", "2026-11-27T00:10:00Z", "2026-11-27T11:00:00Z"]) {
    expect(WORDS.date(eveningOf(nightAround(Date.parse(moment), MONTSEC)))).toBe("2026-11-26");
  }
});
