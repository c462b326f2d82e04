import { describe, expect, test } from "vitest";
import { expiredCaches, handlingOf, mayKeep, type AskedFile } from "../../src/worker/shell-cache.js";

const HUB = "https://hub.test";
const KEPT = new Set(["/offline.html", "/offline.css", "/icon.svg"]);

function handling(path: string, more: Partial<AskedFile> = {}): string {
  return handlingOf({ method: "GET", mode: "cors", url: path.includes("://") ? path : `${HUB}${path}`, ...more }, HUB, KEPT);
}

describe("what the service worker answers", () => {
  test("is files by their hash, and the offline page's own", () => {
    expect(handling("/assets/app-1234.js")).toBe("hashed");
    expect(handling("/offline.css")).toBe("plain");
    expect(handling("/icon-512.png")).toBe("hub");
  });

  test("is pages, which come from the hub while there is one", () => {
    for (const path of ["/", "/home", "/sites/agv/drive?x=1", "/offline.html"]) expect(handling(path, { mode: "navigate" })).toBe("page");
  });

  test.each(["/api/sites", "/api", "/api/sites/agv/frames/1/file", "/ws", "/ws/media", "/extensions/tile.js", "/gateway/enrol"])(
    "is never the hub's data: %s",
    (path) => {
      for (const mode of ["cors", "navigate", "no-cors"]) expect(handling(path, { mode })).toBe("hub");
    },
  );

  test("is nothing that changes something, of another origin, or with a query", () => {
    expect(handling("/assets/app.js", { method: "HEAD" })).toBe("hub");
    expect(handling("/home", { method: "POST", mode: "navigate" })).toBe("hub");
    expect(handling("https://tiles.test/assets/app.js")).toBe("hub");
    expect(handling("/assets/app.js?token=1")).toBe("hub");
    expect(handling("::://")).toBe("hub");
  });

  test("is no page of which the name only begins like the hub's", () => {
    expect(handling("/apiary", { mode: "navigate" })).toBe("page");
  });
});

describe("what is kept", () => {
  const answer = (more: object = {}): Parameters<typeof mayKeep>[0] => ({
    status: 200, type: "basic", redirected: false, headers: new Headers({ "Cache-Control": "public, max-age=31536000, immutable" }), ...more,
  });

  test("is what the hub says never changes, whole and from there", () => {
    expect(mayKeep(answer())).toBe(true);
    for (const more of [{ status: 206 }, { status: 404 }, { type: "opaque" }, { redirected: true }, { headers: new Headers({ "Cache-Control": "no-cache" }) }, { headers: new Headers() }]) {
      expect(mayKeep(answer(more))).toBe(false);
    }
  });

  test("is this version and the one before, for pages that are still open", () => {
    const names = ["other", "talaia-shell-1", "talaia-shell-2", "talaia-shell-3"];
    expect(expiredCaches(names, "talaia-shell-3")).toEqual(["talaia-shell-1"]);
    expect(expiredCaches(["talaia-shell-3"], "talaia-shell-3")).toEqual([]);
    expect(expiredCaches(["talaia-shell-2", "talaia-shell-3"], "talaia-shell-3")).toEqual([]);
  });
});
