import { expect, test } from "vitest";
import { NO_FILTER, auditPageQuery, readAuditFilter, writeAuditFilter } from "../../../src/pages/audit/audit-query.js";

test("the address reads back what it wrote", () => {
  const filter = { who: "ada & co", site: "agv", device: "base", kind: "command", good: "false", fromUs: 5, toUs: 9 } as const;
  expect(readAuditFilter(`?${writeAuditFilter(filter)}`)).toEqual(filter);
  expect(readAuditFilter(writeAuditFilter(NO_FILTER))).toEqual(NO_FILTER);
  expect(writeAuditFilter(NO_FILTER)).toBe("");
});

test.each(["?good=maybe", "?from_us=x", "?from_us=-1", "?to_us=1e9", "?to_us=99999999999999999999"])(
  "%s makes no sense and filters nothing",
  (search) => {
    expect(readAuditFilter(search)).toEqual(NO_FILTER);
  },
);

test("a page is asked for by the last row of the one before", () => {
  expect(auditPageQuery(NO_FILTER, "", 50)).toBe("limit=50");
  expect(auditPageQuery({ ...NO_FILTER, who: "ada" }, "71", 50)).toBe("who=ada&before=71&limit=50");
});
