import { describe, expect, test } from "vitest";
import type { LogLineShape, LogPageShape } from "../../../src/generated/api.js";
import { canGrow, logPageQuery, NO_FILTER, readLogFilter, writeLogFilter } from "../../../src/pages/log/log-query.js";
import { LogPages } from "../../../src/pages/log/log-pages.js";

describe("what is looked for in a robot's log", () => {
  test("comes back from the address as it was written", () => {
    const filter = { text: "over-current", node: "base", level: "40", fromUs: 5, toUs: 9_000_000 };
    expect(readLogFilter(`?${writeLogFilter(filter)}`)).toEqual(filter);
    expect(writeLogFilter(NO_FILTER)).toBe("");
  });

  test("is nothing where the address says no level and no time", () => {
    expect(readLogFilter("?level=loud&from=yesterday&to=")).toEqual(NO_FILTER);
  });

  test("is asked of the hub by its own names, behind a place", () => {
    const asked = new URLSearchParams(logPageQuery({ ...NO_FILTER, level: "30", toUs: 7 }, "7-3"));
    expect(Object.fromEntries(asked)).toEqual({ level: "30", to_us: "7", before: "7-3", limit: "100" });
  });

  test("grows while its end is still to come", () => {
    expect([canGrow(NO_FILTER, 10), canGrow({ ...NO_FILTER, toUs: 11 }, 10), canGrow({ ...NO_FILTER, toUs: 10 }, 10)]).toEqual([true, true, false]);
  });
});

const line = (id: number): LogLineShape => ({ id: String(id), time_us: id, level: 30, node: "base", text: "", function: "", file: "", line: 0, left_out: 0 });

/** A hub that looks through a place at a time: each place has its lines and names the next one. */
function pagesOf(places: readonly (readonly number[])[]): { readonly pages: LogPages; readonly asked: (string | null)[] } {
  const asked: (string | null)[] = [];
  const pages = new LogPages((place): Promise<LogPageShape> => {
    asked.push(place);
    const at = place === null ? 0 : Number(place);
    return Promise.resolve({ lines: (places[at] ?? []).map(line), next: at + 1 < places.length ? String(at + 1) : null });
  });
  return { pages, asked };
}

describe("pages of kept lines", () => {
  test("pass over those of the hub in which nothing was found", async () => {
    const { pages, asked } = pagesOf([[9], [], [], [4]]);
    expect((await pages.findRows("", true)).rows.map(({ id }) => id)).toEqual(["9"]);
    expect(await pages.findRows("9", false)).toEqual({ rows: [line(4)], more: false });
    expect(asked).toEqual([null, "1", "2", "3"]);
  });

  test("show after a while that nothing was found so far, and go on where they stopped", async () => {
    const { pages, asked } = pagesOf([...Array.from({ length: 10 }, () => []), [3]]);
    expect(await pages.findRows("", true)).toEqual({ rows: [], more: true });
    expect(await pages.findRows("", true)).toEqual({ rows: [line(3)], more: false });
    expect(asked).toHaveLength(11);
  });

  test("begin at the newest for new lines, and old ones go on where they were", async () => {
    const { pages, asked } = pagesOf([[9, 8], [7], [6]]);
    await pages.findRows("", true);
    await pages.findRows("8", false);
    await pages.findRows("", false);
    expect((await pages.findRows("7", false)).rows.map(({ id }) => id)).toEqual(["6"]);
    expect(asked).toEqual([null, "1", null, "2"]);
  });
});
