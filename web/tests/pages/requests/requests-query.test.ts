import { expect, test } from "vitest";
import { readRequestsFilter, requestsPageQuery, writeRequestsFilter } from "../../../src/pages/requests/requests-query.js";

test("a filter comes back from the address, and a state that there is not counts as none", () => {
  const filter = { text: "M 31", proposal: "P1", state: "PENDING", mine: true, waiting: false };
  expect(readRequestsFilter(writeRequestsFilter(filter))).toEqual(filter);
  expect(readRequestsFilter("state=OPEN&waiting=true")).toMatchObject({ state: "", waiting: true });
  expect(requestsPageQuery(filter, "17", 50)).toBe("text=M+31&proposal=P1&state=PENDING&mine=true&before=17&limit=50");
});
