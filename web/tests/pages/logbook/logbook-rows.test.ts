import { expect, test } from "vitest";
import type { EventShape, NoteShape } from "../../../src/generated/api.js";
import { NO_FILTER } from "../../../src/pages/logbook/logbook-query.js";
import { readLogbookPage, type LogbookRow, type LogbookSources } from "../../../src/pages/logbook/logbook-rows.js";

const event = (at: number): EventShape => ({ id: String(at), time_us: at, kind: "stop", device: "base", who: "", message: "", good: true });
const note = (at: number): NoteShape => ({
  id: String(at), device: "base", signal: "", from_us: at, to_us: at, text: "x", who: "ada", created_us: 1, changed_us: 1, changed_by: "ada", version: 1, may_change: true,
});

/** Stands for the hub: lines and notes at these moments, paged and filtered as it does. */
function hubOf(events: readonly number[], notes: readonly number[]): LogbookSources {
  const page = <R>(rows: readonly number[], query: string, make: (at: number) => R): { found: R[]; more: boolean } => {
    const asked = new URLSearchParams(query);
    const [limit, before] = [Number(asked.get("limit")), Number(asked.get("before") ?? Infinity)];
    const [from, to] = [Number(asked.get("from_us") ?? 0), Number(asked.get("to_us") ?? Infinity)];
    const left = [...rows].sort((a, b) => b - a).filter((at) => at < before && at >= from && at <= to);
    return { found: left.slice(0, limit).map(make), more: left.length > limit };
  };
  return {
    events: { events: (_site, query) => { const { found, more } = page(events, query, event); return Promise.resolve({ events: found, more }); } },
    notes: { findNotes: (query) => { const { found, more } = page(notes, query, note); return Promise.resolve({ notes: found, more }); } },
  };
}

async function readAll(hub: LogbookSources, filter = NO_FILTER): Promise<readonly LogbookRow[]> {
  let rows: readonly LogbookRow[] = [];
  for (let more = true; more; ) {
    const page = await readLogbookPage(hub, "agv", filter, rows.at(-1), 3);
    rows = [...rows, ...page.rows];
    more = page.more;
  }
  return rows;
}

test("page by page each note stands once, at its own moment between the lines", async () => {
  const [events, notes] = [[10, 20, 30, 40, 50, 60, 70], [5, 20, 35, 50, 51, 90]];
  const rows = await readAll(hubOf(events, notes));
  expect(rows.map(({ time_us }) => time_us)).toEqual([...events, ...notes].sort((a, b) => b - a));
  expect(new Set(rows.map(({ id }) => id)).size).toBe(rows.length);
});

test("a filter by notes lists notes alone, and one by anything else none", async () => {
  const hub = hubOf([10, 20], [1, 2, 3, 4, 5]);
  expect((await readAll(hub, { ...NO_FILTER, kind: "note" })).map(({ time_us }) => time_us)).toEqual([5, 4, 3, 2, 1]);
  expect((await readAll(hub, { ...NO_FILTER, kind: "stop" })).every((row) => !("note" in row))).toBe(true);
  expect((await readAll(hub, { ...NO_FILTER, bad: true })).every((row) => !("note" in row))).toBe(true);
});
