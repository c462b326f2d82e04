import { expect, test } from "vitest";
import type { GroupAsk } from "../../../src/generated/api.js";
import { groupTitle, guessKind, readText, shutterOf } from "../../../src/pages/requests/import-file.js";

const M42 = { target: { type: "ICRS", name: "M 42", ra: 83.8, dec: -5.4 }, configurations: [{ exposure: 30, count: 4 }, { exposure: 60 }], windows: [] } as const;
const NAMELESS = { target: null, configurations: [{ exposure: 10 }], windows: [] };

test("whose file it is stands in the file, whatever its name says, and in its name where it is empty", () => {
  expect(guessKind("targets.txt", "\ufeffname,ra,dec\n")).toBe("csv");
  expect(guessKind("export.json", ' [{"requests": []}]')).toBe("lco");
  expect(guessKind("night.txt", '{"$type": "NINA.Sequencer.Container.SequenceRootContainer"}')).toBe("nina");
  expect(guessKind("night.csv", '<?xml version="1.0"?><SchedulerList/>')).toBe("ekos");
  expect(guessKind("night.ESL", "")).toBe("ekos");
  expect(guessKind("night", "")).toBe("csv");
});

test("what was read and what was not is said in one sentence", () => {
  const group: GroupAsk = { proposal: "P", requests: [M42, NAMELESS] };
  const problem = { where: "line 3, ra", message: "expected a number, found 'x'" };
  expect(readText({ groups: [group], problems: [] })).toBe("2 requests in 1 group.");
  expect(readText({ groups: [group, group], problems: [problem] })).toBe("4 requests in 2 groups; 1 part could not be read and would be left out.");
  expect(readText({ groups: [], problems: [problem, problem] })).toMatch(/^No request could be read; 2 parts/);
});

test("a group is called by its name and its first targets", () => {
  const group: GroupAsk = { proposal: "P", name: "Orion", requests: [M42, NAMELESS, M42] };
  expect(groupTitle(group)).toBe("Orion: M 42, no name, M 42");
  expect(groupTitle({ ...group, name: "" }, 1)).toBe("M 42 and 2 more");
  expect(shutterOf(group)).toBe(2 * 180 + 10);
});
