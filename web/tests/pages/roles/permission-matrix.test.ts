import { describe, expect, test } from "vitest";
import { changesOf, cellOf, draftsOf, withLevelEdited, withExtraEdited, isChanged, matrixLines, updatedDrafts } from "../../../src/pages/roles/permission-matrix.js";
import { ANY, EVERYWHERE } from "../../../src/state/rights.js";
import type { DeviceSummary, PermissionShape, RoleShape } from "../../../src/generated/api.js";

const row = (site: string, device: string): DeviceSummary => ({
  site, site_name: `Site ${site}`, device, name: `Device ${device}`, kind: "other", online: true, rights: [],
  public: device === "base", signals: 1, stale: 0,
});
const role = (name: string, permissions: readonly PermissionShape[] = [], seeded = false): RoleShape => ({
  id: name, name, seeded, people: 0, factor_required: false, permissions,
});
const DEVICES = [row("agv", "base"), row("agv", "arm"), row("dome", "roof")];
const ADMIN = role("admin", [{ right: "admin", site: ANY, device: ANY }], true);
const base = { site: "agv", device: "base" };

describe("the lines", () => {
  test("are the hub, then each site with its devices", () => {
    const shown = matrixLines(DEVICES, []).map(({ depth, name }) => `${String(depth)} ${name}`);
    expect(shown).toEqual([
      "0 Every site", "1 Site agv", "2 Device base", "2 Device arm", "1 Site dome", "2 Device roof",
    ]);
  });

  test("hold also what a role names and no gateway has told of", () => {
    const crew = role("crew", [{ right: "view", site: "far", device: "mast" }]);
    const lines = matrixLines([], [crew]);
    expect(lines.map(({ site, device }) => `${site} ${device}`)).toEqual(["* *", "far *", "far mast"]);
  });
});

describe("a cell", () => {
  test("says what is given there and what comes from above", () => {
    const cell = cellOf([{ right: "view", site: "agv", device: ANY }], base);
    expect(cell).toMatchObject({ own: "none", inherited: "view", level: "view" });
  });

  test("set to what comes from above gives nothing of its own", () => {
    const crew = role("crew", [{ right: "view", site: "agv", device: ANY }, { right: "use", ...base }]);
    const [draft] = withLevelEdited(draftsOf([crew]), "crew", base, "view");
    expect(draft?.permissions).toEqual([{ right: "view", site: "agv", device: ANY }]);
  });

  test("opens raw topics beside its level, and keeps them when the level changes", () => {
    const crew = role("crew", [{ right: "view", ...base }]);
    const opened = withExtraEdited(draftsOf([crew]), "crew", base, { right: "tap", given: true });
    const [draft] = withLevelEdited(opened, "crew", base, "use");
    expect(draft?.permissions).toEqual([{ right: "tap", ...base }, { right: "use", ...base }]);
    expect(changesOf(opened, matrixLines(DEVICES, []))).toEqual([
      { role: "crew", place: "Site agv, Device base", before: "view", after: "view, tap" },
    ]);
    expect(withExtraEdited(opened, "crew", base, { right: "tap", given: false })[0]?.permissions).toEqual(crew.permissions);
  });

  test("of the role that can do everything cannot be changed", () => {
    const drafts = draftsOf([ADMIN]);
    expect(withLevelEdited(drafts, "admin", EVERYWHERE, "none")).toEqual(drafts);
  });
});

describe("changes", () => {
  const crew = role("crew", [{ right: "view", site: "dome", device: ANY }]);
  const lines = matrixLines(DEVICES, [ADMIN, crew]);

  test("are told by role and place, before and after", () => {
    const drafts = withLevelEdited(draftsOf([ADMIN, crew]), "crew", base, "use");
    expect(changesOf(drafts, lines)).toEqual([
      { role: "crew", place: "Site agv, Device base", before: "none", after: "use" },
    ]);
    expect(drafts.map(isChanged)).toEqual([false, true]);
  });

  test("that are taken back are none", () => {
    const there = withLevelEdited(draftsOf([crew]), "crew", base, "use");
    expect(changesOf(withLevelEdited(there, "crew", base, "none"), lines)).toEqual([]);
  });

  test("that are not saved outlive a fresh look at the hub, and saved ones do not", () => {
    const drafts = withLevelEdited(draftsOf([crew]), "crew", base, "use");
    const other = role("other");
    expect(updatedDrafts(drafts, [crew, other]).map(isChanged)).toEqual([true, false]);
    const saved = { ...crew, permissions: drafts[0]?.permissions ?? [] };
    expect(updatedDrafts(drafts, [saved]).map(isChanged)).toEqual([false]);
  });
});
