import { expect, test } from "vitest";
import { firstPage, isOpen, mayOpen, PAGES } from "../../src/pages/routes.js";
import { ADMIN_PAGES } from "../../src/state/router.js";
import type { Me } from "../../src/generated/api.js";

const person = (change: Partial<Me> = {}): Me => ({
  name: "ada", role: "operator", admin: false, factor: false, factor_missing: false, codes_locked_us: 0, password: true, idle_ends_us: 0, ends_us: 0,
  permissions: [{ right: "view", site: "agv", device: "base" }], ...change,
});
const guest = person({ role: "guest", permissions: [] });

test("an admin's pages are an admin's alone", () => {
  for (const page of ADMIN_PAGES) {
    expect(mayOpen(page, person())).toBe(false);
    expect(mayOpen(page, person({ admin: true }))).toBe(true);
    expect(isOpen(page)).toBe(false);
  }
});

test("who sees only what is public begins there, and has nothing to actuate", () => {
  expect(firstPage(guest)).toBe("/public");
  expect(firstPage(person())).toBe("/home");
  expect(mayOpen("drive", guest)).toBe(false);
  expect(mayOpen("drive", person())).toBe(true);
});

test("every page has a tag of its own", () => {
  const tags = Object.values(PAGES).map(({ tag }) => tag);
  expect(new Set(tags).size).toBe(tags.length);
});
