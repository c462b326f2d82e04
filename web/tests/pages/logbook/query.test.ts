import { expect, test } from "vitest";
import { momentQuery, NO_FILTER, pageQuery, readFilter, writeFilter } from "../../../src/pages/logbook/query.js";

test("a filter survives the address, and all of it is as if there were none", () => {
  const filter = { text: "rain & wind", kind: "alarm", device: "dome", who: "ada", bad: true };
  expect(readFilter(`?${writeFilter(filter)}`)).toEqual(filter);
  expect(writeFilter(NO_FILTER)).toBe("");
  expect(readFilter("?good=maybe&before=7")).toEqual(NO_FILTER);
});

test("the next page is asked for by the last row of this one", () => {
  expect(pageQuery({ ...NO_FILTER, kind: "stop" }, "17", 50)).toBe("kind=stop&before=17&limit=50");
  expect(pageQuery(NO_FILTER, "", 50)).toBe("limit=50");
});

test("an event leads to the history around its moment", () => {
  expect(momentQuery(100e6)).toBe("from=40000000&to=160000000");
});
