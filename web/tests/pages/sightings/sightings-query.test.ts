import { expect, test } from "vitest";
import type { SightingUpdate } from "../../../src/generated/wire.js";
import { historyQuery, matchingLabel, NO_FILTER, sightingsPageQuery, readSightingFilter, withUpdate, writeSightingFilter } from "../../../src/pages/sightings/sightings-query.js";
import type { SeenShape, SiteShape } from "../../../src/generated/api.js";

const LABELS = ["person", "dog", "wine glass", "hot dog"];
const row = (id: number, more: Partial<SeenShape> = {}): SeenShape => ({
  id: String(id), camera: "camera/front", label: "person", many: 1, confidence: 0.8, began_us: 100e6, ended_us: null, picture: false, story: null, ...more,
});

test("a filter survives the address, and all of it is as if there were none", () => {
  const filter = { what: "wine & glass", camera: "camera/front", fromUs: 0, toUs: 1_780_000_000_000_000, open: true };
  expect(readSightingFilter(`?${writeSightingFilter(filter)}`)).toEqual(filter);
  expect(writeSightingFilter(NO_FILTER)).toBe("");
  expect(readSightingFilter("?from=&to=soon&open=1")).toEqual(NO_FILTER);
});

test("what is typed finds its class: whatever its case, in the plural, and by a part that no other has", () => {
  const typed = ["Person", " persons", "wine", "dogs", "dog", "do", "zebra", ""];
  expect(typed.map((address) => matchingLabel(address, LABELS))).toEqual(["person", "person", "wine glass", "dog", "dog", "do", "zebra", ""]);
});

test("the hub is asked in its own words, and for the next page by the last row of this one", () => {
  expect(sightingsPageQuery(NO_FILTER, LABELS, "", 30)).toBe("limit=30");
  const asked = sightingsPageQuery({ what: "Dogs", camera: "c/f", fromUs: 5, toUs: 9, open: true }, LABELS, "17", 30);
  expect(asked).toBe("label=dog&camera=c%2Ff&from_us=5&to_us=9&open=true&before=17&limit=30");
});

test("news changes the row that it is about, and says where there is none", () => {
  const news: SightingUpdate = { t: "sighting", site: "agv", id: 2, camera: "camera/front", label: "person", many: 3, confidence: 0.9, began_us: 100e6, ended_us: 180e6 };
  expect(withUpdate([row(2), row(1)], news)).toEqual([row(2, { many: 3, confidence: 0.9, ended_us: 180e6 }), row(1)]);
  expect(withUpdate([row(2)], { ...news, ended_us: 0 })?.[0]?.ended_us).toBeNull();
  expect(withUpdate([row(1)], news)).toBeNull();
});

test("a sighting leads to the history around it, with the signal that counts such things", () => {
  const detail = { devices: [{ signals: [{ address: "camera/front_person", channels: ["camera/front_person"] }] }] } as unknown as SiteShape;
  expect(historyQuery(row(1), detail)).toBe("c=camera/front_person&from=40000000&to=160000000&at=100000000");
  expect(historyQuery(row(1, { label: "dog", ended_us: 130e6 }), detail)).toBe("from=40000000&to=190000000&at=100000000");
  expect(historyQuery(row(1), undefined)).toBe("from=40000000&to=160000000&at=100000000");
});
