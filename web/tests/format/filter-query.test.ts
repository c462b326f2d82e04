import { expect, test } from "vitest";
import { formTexts, pageQuery, queryTexts, textsQuery } from "../../src/format/filter-query.js";

const KEYS = ["who", "device"] as const;

test("what a form says comes back from the address it is written to", () => {
  const said = new FormData();
  said.set("who", " anna ");
  said.set("device", "dome & roof");
  const texts = formTexts(said, KEYS);
  expect(texts).toEqual({ who: "anna", device: "dome & roof" });
  expect(queryTexts(new URLSearchParams(textsQuery(texts, KEYS).toString()), KEYS)).toEqual(texts);
});

test("a text that is empty is not in the address, and an address without it gives an empty one", () => {
  expect(textsQuery({ who: "", device: "dome" }, KEYS).toString()).toBe("device=dome");
  expect(queryTexts(new URLSearchParams("device=dome&other=1"), KEYS)).toEqual({ who: "", device: "dome" });
});

test("a text of an address is cut to what the hub takes", () => {
  expect(queryTexts(new URLSearchParams(`who=${"a".repeat(300)}`), KEYS).who).toHaveLength(200);
});

test("a page is asked for behind a row, the newest behind none", () => {
  expect(pageQuery("who=anna", "17", 50)).toBe("who=anna&before=17&limit=50");
  expect(pageQuery("", "", 50)).toBe("limit=50");
});
