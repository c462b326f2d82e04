import { describe, expect, test } from "vitest";
import { permissionText } from "../../src/format/permissions.js";

describe("permissions", () => {
test("permissions are told by place", () => {
  expect(permissionText([])).toBe("nothing");
  expect(
    permissionText([
      { right: "view", site: "*", device: "*" },
      { right: "use", site: "agv", device: "base" },
      { right: "use", site: "dome", device: "*" },
    ]),
  ).toBe("view every site, use agv base, use all of dome");
});
});
