import { expect, test } from "vitest";
import { DiagnosticsBook, diagnosticParts, nodeMatches, type DiagnosticNode } from "../../src/series/diagnostics.js";

const status = (name: string, level: number, message = "", values: readonly object[] = []): object => ({ name, level, message, hardware_id: "", values });

function nodeAt(root: DiagnosticNode, path: string): DiagnosticNode | undefined {
  return root.path === path ? root : root.children.map((child) => nodeAt(child, path)).find((found) => found !== undefined);
}

test("names are parts between slashes, or a node and what is behind it", () => {
  expect(diagnosticParts("/Robot/Arm/motor")).toEqual(["Robot", "Arm", "motor"]);
  expect(diagnosticParts("joy_node: Joystick: state")).toEqual(["joy_node", "Joystick: state"]);
  expect(diagnosticParts("alone")).toEqual(["alone"]);
  expect(diagnosticParts("")).toEqual(["(no name)"]);
});

test("each part is as grave as the gravest in it", () => {
  const book = new DiagnosticsBook();
  book.addMessage({ status: [status("/a/b/ok", 0), status("/a/b/warn", 1), status("/a/c", 2), status("/d", 0)] }, 0);
  const root = book.treeAt(100);
  expect([root, nodeAt(root, "a"), nodeAt(root, "a/b"), nodeAt(root, "d")].map((node) => node?.level)).toEqual(["error", "error", "warn", "ok"]);
  expect(root.counts).toEqual({ ok: 2, warn: 1, error: 1, stale: 0 });
});

test("a level that nobody knows is an error, and never as good as OK", () => {
  const book = new DiagnosticsBook();
  book.addMessage({ status: [status("a", 7), { name: "b" }] }, 0);
  expect(book.treeAt(0).counts.error).toBe(2);
});

test("what is not said again grows stale, after three times the time that it took before", () => {
  const book = new DiagnosticsBook();
  book.addMessage({ status: [status("slow", 0), status("quick", 0)] }, 0);
  book.addMessage({ status: [status("quick", 0)] }, 500);
  book.addMessage({ status: [status("slow", 0)] }, 4000);
  expect(book.treeAt(5400).counts).toEqual({ ok: 2, warn: 0, error: 0, stale: 0 });
  const later = book.treeAt(5600);
  expect([nodeAt(later, "quick")?.level, nodeAt(later, "slow")?.level]).toEqual(["stale", "ok"]);
  expect(book.treeAt(16_100).counts.stale).toBe(2);
  book.addMessage({ status: [status("quick", 1)] }, 17_000);
  expect(nodeAt(book.treeAt(17_000), "quick")?.level).toBe("warn");
});

test("several nodes publish on one topic: what one does not say is not forgotten", () => {
  const book = new DiagnosticsBook();
  book.addMessage({ status: [status("a", 0)] }, 0);
  book.addMessage({ status: [status("b", 0, "", [{ key: "k", value: "v" }])] }, 10);
  expect(book.size).toBe(2);
  expect(nodeAt(book.treeAt(20), "b")?.status?.values).toEqual([["k", "v"]]);
});

test("names are kept up to a bound, the newest of them", () => {
  const book = new DiagnosticsBook();
  for (let at = 0; at < 2100; at++) book.addMessage({ status: [status(`name ${String(at)}`, 0)] }, at);
  expect(book.size).toBe(2000);
  expect(nodeAt(book.treeAt(2100), "name 0")).toBeUndefined();
  expect(nodeAt(book.treeAt(2100), "name 2099")).toBeDefined();
});

test("messages that are none change nothing, and cut ones say so", () => {
  const book = new DiagnosticsBook();
  for (const odd of [null, 1, {}, { status: 5 }]) book.addMessage(odd, 0);
  expect(book.size).toBe(0);
  book.addMessage({ status: { $first: [status("a", 0)], $of: 1500 } }, 0);
  expect([book.size, book.leftOut]).toEqual([1, 1499]);
});

test("a search finds names and what is said below a node", () => {
  const book = new DiagnosticsBook();
  book.addMessage({ status: [status("/a/b", 0, "All Warm"), status("/c", 0)] }, 0);
  const root = book.treeAt(0);
  expect(root.children.map((node) => nodeMatches(node, "warm"))).toEqual([true, false]);
});
