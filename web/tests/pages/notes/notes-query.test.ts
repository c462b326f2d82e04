import { expect, test } from "vitest";
import type { NoteShape } from "../../../src/generated/api.js";
import { noteMarks } from "../../../src/pages/notes/note-marks.js";
import { draftAt, draftOf, NO_SEARCH, noteHistoryPath, notesPageQuery, readNoteSearch, writeNoteSearch } from "../../../src/pages/notes/notes-query.js";

const NOTE: NoteShape = {
  id: "7", device: "base", signal: "", from_us: 100e6, to_us: 130e6, text: "slipped", who: "ada", created_us: 1, changed_us: 1, changed_by: "ada", version: 3, may_change: true,
};

test("a search survives the address, and all of it is as if there were none", () => {
  const search = { text: "wheel & rain", who: "ada", device: "base", fromUs: 0, toUs: 17 };
  expect(readNoteSearch(`?${writeNoteSearch(search)}`)).toEqual(search);
  expect(writeNoteSearch(NO_SEARCH)).toBe("");
  expect(readNoteSearch("?from=soon&to=-1&other=1")).toEqual(NO_SEARCH);
});

test("the hub is asked for a span by its own words, and for the next page by the last note", () => {
  expect(notesPageQuery({ ...NO_SEARCH, who: "ada", fromUs: 5, toUs: 6 }, "17", 50)).toBe("who=ada&from_us=5&to_us=6&before=17&limit=50");
});

test("a note is changed from the version that was seen, and a new one is of a moment", () => {
  expect(draftOf(NOTE)).toMatchObject({ id: "7", version: 3, fromUs: 100e6, toUs: 130e6 });
  expect(draftAt(5.4)).toMatchObject({ id: "", fromUs: 5, toUs: 5 });
});

test("a note leads to the charts around all of its span", () => {
  expect(noteHistoryPath("agv", NOTE, undefined)).toBe("/sites/agv/history?from=40000000&to=190000000&at=100000000");
});

test("a note over a span is a mark that lasts, one at a moment is not", () => {
  const names = new Map([["base", "Base"]]);
  const [span, moment] = noteMarks([NOTE, { ...NOTE, to_us: 100e6 }], names);
  expect(span).toMatchObject({ kind: "note", timeUs: 100e6, untilUs: 130e6, device: "Base", who: "ada", message: "slipped" });
  expect(moment).not.toHaveProperty("untilUs");
});
