import { expect, test } from "vitest";
import { scopesOf } from "../../../src/pages/account/token-scopes.js";
import { ANY } from "../../../src/state/rights.js";
import type { DeviceSummary, PermissionShape } from "../../../src/generated/api.js";

const row = (device: string): DeviceSummary => ({
  site: "agv", site_name: "House", device, name: device, kind: "other", online: true, rights: [], public: true,
  signals: 1, stale: 0,
});
const shown = (permissions: readonly PermissionShape[]): string[] =>
  scopesOf(permissions, [row("base"), row("arm")]).map(({ name, most }) => `${name} ${most}`);

test("a token may be given what its maker has, and nothing wider", () => {
  expect(shown([{ right: "use", site: "agv", device: "base" }])).toEqual(["base use"]);
  expect(shown([{ right: "view", site: "agv", device: ANY }])).toEqual(["House view", "base view", "arm view"]);
});

test("an admin's token may use everything and manage nothing", () => {
  expect(shown([{ right: "admin", site: ANY, device: ANY }])).toEqual([
    "Every site use", "House use", "base use", "arm use",
  ]);
});

test("who has no right has none to pass on", () => {
  expect(shown([])).toEqual([]);
});
